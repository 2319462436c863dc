#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/random.h"
#include "reduction/allocation.h"

namespace relume {
namespace {

/// Largest remainder written the slow way: whole parts first, then one record at a time to the type
/// with the largest remainder, more samples, lower index.
std::vector<int> brute_force(const std::vector<int>& counts, int k) {
  const int total = std::accumulate(counts.begin(), counts.end(), 0);
  if (k >= total) return counts;
  std::vector<int> result;
  std::vector<bool> served(counts.size(), false);
  for (const int n : counts) result.push_back(k * n / total);
  while (std::accumulate(result.begin(), result.end(), 0) < k) {
    int best = -1;
    for (int t = 0; t < static_cast<int>(counts.size()); ++t) {
      if (served[t] || result[t] >= counts[t]) continue;
      if (best < 0) {
        best = t;
        continue;
      }
      const int remainder = k * counts[t] % total;
      const int best_remainder = k * counts[best] % total;
      if (remainder > best_remainder || (remainder == best_remainder && counts[t] > counts[best])) {
        best = t;
      }
    }
    served[best] = true;
    ++result[best];
  }
  return result;
}

/// Every split of up to `total` samples into three types.
template <class Body>
void for_each_split(int total, const Body& body) {
  for (int a = 0; a <= total; ++a) {
    for (int b = 0; a + b <= total; ++b) {
      for (int c = 0; a + b + c <= total; ++c) body(std::vector<int>{a, b, c});
    }
  }
}

TEST(Allocation, EqualsBruteForceForEverySplit) {
  for_each_split(14, [](const std::vector<int>& counts) {
    for (int k = 0; k <= 16; ++k) {
      ASSERT_EQ(allocate_records(counts, k, false), brute_force(counts, k))
          << counts[0] << " " << counts[1] << " " << counts[2] << " k " << k;
    }
  });
}

TEST(Allocation, SumsToKOrToAllSamplesAndKeepsTheCaps) {
  for (uint64_t i = 0; i < 3000; ++i) {
    Random random(1, RandomStream::tests, i);
    std::vector<int> counts(1 + random.below(10));
    for (int& n : counts) n = static_cast<int>(random.below(30));
    const int total = std::accumulate(counts.begin(), counts.end(), 0);
    const int k = static_cast<int>(random.below(65));
    for (const bool at_least_one : {false, true}) {
      const std::vector<int> result = allocate_records(counts, k, at_least_one);
      ASSERT_EQ(std::accumulate(result.begin(), result.end(), 0), std::min(k, total));
      for (size_t t = 0; t < counts.size(); ++t) {
        ASSERT_GE(result[t], 0);
        ASSERT_LE(result[t], counts[t]);
        // Proportional to within one record.
        if (!at_least_one && k < total) {
          ASSERT_LT(std::abs(result[t] - static_cast<double>(k) * counts[t] / total), 1.0);
        }
      }
    }
  }
}

TEST(Allocation, KeepsTypesOfAnEighthOfARecordWhileKAllows) {
  for_each_split(14, [](const std::vector<int>& counts) {
    const int total = std::accumulate(counts.begin(), counts.end(), 0);
    for (int k = 0; k <= 14; ++k) {
      const std::vector<int> result = allocate_records(counts, k, true);
      const std::vector<int> plain = allocate_records(counts, k, false);
      const auto is_kept = [&](int n) { return n > 0 && 8 * n * k >= total; };
      const auto kept = std::count_if(counts.begin(), counts.end(), is_kept);
      const auto served = std::count_if(result.begin(), result.end(), [](int n) { return n > 0; });
      ASSERT_GE(served, std::min<std::ptrdiff_t>(kept, k));
      ASSERT_EQ(std::accumulate(result.begin(), result.end(), 0), std::min(k, total));
      for (size_t t = 0; t < counts.size(); ++t) {
        // A type of less than an eighth of a record has none but by the plain rounding.
        if (!is_kept(counts[t])) {
          ASSERT_LE(result[t], plain[t]);
        }
      }
    }
  });
}

TEST(Allocation, LosesRareTypesWithoutTheOption) {
  EXPECT_EQ(allocate_records(std::vector<int>{24, 1}, 8, false), (std::vector<int>{8, 0}));
  EXPECT_EQ(allocate_records(std::vector<int>{24, 1}, 8, true), (std::vector<int>{7, 1}));
  EXPECT_EQ(allocate_records(std::vector<int>{24, 1}, 4, true), (std::vector<int>{3, 1}));
  EXPECT_EQ(allocate_records(std::vector<int>{24, 1}, 3, true), (std::vector<int>{3, 0}));
}

TEST(Allocation, TiesGoToTheLargerCountThenTheLowerIndex) {
  EXPECT_EQ(allocate_records(std::vector<int>{5, 5}, 1, false), (std::vector<int>{1, 0}));
  EXPECT_EQ(allocate_records(std::vector<int>{5, 5}, 3, false), (std::vector<int>{2, 1}));
  // 4 * 9 / 12 = 3 and 4 * 3 / 12 = 1: exact, no tie to break.
  EXPECT_EQ(allocate_records(std::vector<int>{3, 9}, 4, false), (std::vector<int>{1, 3}));
  // 2 * 1 / 4, 2 * 3 / 4: both remainders are one half.
  EXPECT_EQ(allocate_records(std::vector<int>{1, 3}, 2, false), (std::vector<int>{0, 2}));
}

TEST(Allocation, HandlesNothing) {
  EXPECT_EQ(allocate_records({}, 8, true), std::vector<int>());
  EXPECT_EQ(allocate_records(std::vector<int>{0, 0}, 8, true), (std::vector<int>{0, 0}));
  EXPECT_EQ(allocate_records(std::vector<int>{3, 2}, 0, true), (std::vector<int>{0, 0}));
}

}  // namespace
}  // namespace relume

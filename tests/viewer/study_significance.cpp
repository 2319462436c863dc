#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "viewer/study/significance.h"

namespace relume {
namespace {

/// By trying all signs.
double brute_force_p(const std::vector<double>& ranks, const std::vector<bool>& positive) {
  double all = 0;
  double seen = 0;
  for (size_t i = 0; i < ranks.size(); ++i) {
    all += ranks[i];
    if (positive[i]) seen += ranks[i];
  }
  const double smaller = std::min(seen, all - seen);
  int extreme = 0;
  for (uint32_t signs = 0; signs < (1u << ranks.size()); ++signs) {
    double sum = 0;
    for (size_t i = 0; i < ranks.size(); ++i) {
      if (signs >> i & 1) sum += ranks[i];
    }
    if (sum <= smaller) ++extreme;
  }
  return std::min(1.0, 2.0 * extreme / (1u << ranks.size()));
}

TEST(SignedRank, EqualsAllSignsTried) {
  Random random(1, RandomStream::tests, 0);
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<double> differences;
    std::vector<double> ranks;
    std::vector<bool> positive;
    for (int rank = 1; rank <= 10; ++rank) {
      positive.push_back(random.below(3) > 0);
      differences.push_back(positive.back() ? rank : -rank);
      ranks.push_back(rank);
    }
    EXPECT_NEAR(signed_rank_p(differences), brute_force_p(ranks, positive), 1e-12) << trial;
  }
}

TEST(SignedRank, SharesRanksAmongTiesAndLeavesZerosOut) {
  const std::vector<double> differences{0, 1, 1, -1, 2, 0, -2, 5};
  EXPECT_NEAR(signed_rank_p(differences),
              brute_force_p({2, 2, 2, 4.5, 4.5, 6}, {true, true, false, true, false, true}), 1e-12);
}

TEST(SignedRank, IsTwoInTwoToTheNForOneSidedDifferences) {
  std::vector<double> differences;
  for (int i = 1; i <= 50; ++i) differences.push_back(i);
  EXPECT_NEAR(signed_rank_p(differences), 2 * std::pow(0.5, 50), 1e-20);
  EXPECT_EQ(signed_rank_p({}), 1);
  EXPECT_EQ(signed_rank_p(std::vector<double>{0, 0}), 1);
}

TEST(SignedRank, GoesOverIntoTheNormalApproximation) {
  Random random(2, RandomStream::tests, 0);
  std::vector<double> differences;
  for (int i = 0; i < 200; ++i) differences.push_back(random.uniform() - 0.44);
  const double exact = signed_rank_p(differences);
  differences.push_back(1e-9);
  EXPECT_NEAR(signed_rank_p(differences) / exact, 1, 0.05);
  EXPECT_LT(exact, 0.5);
  EXPECT_GT(exact, 1e-6);
}

TEST(Holm, MultipliesByHowManyAreLeftAndNeverFalls) {
  const std::vector<double> adjusted = holm_adjust(std::vector<double>{0.03, 0.01, 0.04, 0.5});
  ASSERT_EQ(adjusted.size(), 4u);
  EXPECT_DOUBLE_EQ(adjusted[1], 0.04);
  EXPECT_DOUBLE_EQ(adjusted[0], 0.09);
  EXPECT_DOUBLE_EQ(adjusted[2], 0.09) << "0.08 would be less than the one before";
  EXPECT_DOUBLE_EQ(adjusted[3], 0.5);
  EXPECT_TRUE(holm_adjust({}).empty());
}

TEST(MeanInterval, HasTheWidthsOfStudentsTable) {
  // Values at -1 and 1: the standard deviation is sqrt(n / (n - 1)), the half width t / sqrt(n -
  // 1).
  const std::pair<int, double> table[] = {
      {2, 12.706}, {4, 3.182}, {6, 2.571}, {16, 2.131}, {50, 2.0096}};
  for (const auto& [n, t] : table) {
    std::vector<double> values;
    for (int i = 0; i < n; ++i) values.push_back(i % 2 == 0 ? -1 : 1);
    const MeanInterval interval = mean_interval(values);
    EXPECT_EQ(interval.mean, 0);
    EXPECT_NEAR(interval.half_95 * std::sqrt(n - 1.0) / t, 1, 0.01) << n;
  }
  EXPECT_EQ(mean_interval(std::vector<double>{3.0}).half_95, 0);
  EXPECT_EQ(mean_interval({}).mean, 0);
}

}  // namespace
}  // namespace relume

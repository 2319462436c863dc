#include "reduction/allocation.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

#include "core/base/check.h"

namespace relume {
namespace {

/// Type indices, by remainder of k n_t / n downwards, then by count, then by index.
std::vector<int> order_by_remainder(std::span<const int> counts, int64_t k, int64_t total) {
  std::vector<int> order(counts.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    const int64_t remainder_a = k * counts[a] % total;
    const int64_t remainder_b = k * counts[b] % total;
    if (remainder_a != remainder_b) return remainder_a > remainder_b;
    return counts[a] > counts[b];
  });
  return order;
}

/// Gives types without a record one of those of the richest type, unless an eighth of a record
/// is more than their share of k.
void keep_rare_types(std::span<const int> counts, int64_t k, int64_t total,
                     std::vector<int>& allocation) {
  std::vector<int> order(counts.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return counts[a] > counts[b]; });
  for (const int needy : order) {
    if (allocation[needy] > 0 || 8 * counts[needy] * k < total) continue;
    const auto richest = std::max_element(allocation.begin(), allocation.end());
    if (*richest < 2) return;
    --*richest;
    ++allocation[needy];
  }
}

}  // namespace

std::vector<int> allocate_records(std::span<const int> samples_per_type, int k, bool keep_types) {
  CHECK_MSG(k >= 0, "k {}", k);
  const std::span<const int> counts = samples_per_type;
  const int64_t total = std::accumulate(counts.begin(), counts.end(), int64_t{0});
  std::vector<int> allocation(counts.begin(), counts.end());
  if (k >= total) return allocation;
  int64_t left = k;
  for (size_t t = 0; t < counts.size(); ++t) {
    allocation[t] = static_cast<int>(int64_t{k} * counts[t] / total);
    left -= allocation[t];
  }
  // With k < n each floor is below n_t wherever the remainder is not zero, so one round suffices.
  for (const int t : order_by_remainder(counts, k, total)) {
    if (left == 0) break;
    if (allocation[t] >= counts[t]) continue;
    ++allocation[t];
    --left;
  }
  if (keep_types) keep_rare_types(counts, k, total, allocation);
  return allocation;
}

}  // namespace relume

#include "viewer/study/significance.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace relume {
namespace {

constexpr size_t exact_limit = 200;

/// Twice the mean ranks of |differences|, so that ties stay whole, in the order of size.
struct SignedRanks {
  std::vector<int> doubled;
  std::vector<bool> positive;
};

SignedRanks rank_differences(std::span<const double> differences) {
  std::vector<double> sorted;
  for (const double d : differences) {
    if (d != 0) sorted.push_back(d);
  }
  std::ranges::sort(sorted, [](double a, double b) { return std::abs(a) < std::abs(b); });
  SignedRanks ranks;
  for (size_t first = 0; first < sorted.size();) {
    size_t end = first + 1;
    while (end < sorted.size() && std::abs(sorted[end]) == std::abs(sorted[first])) ++end;
    for (size_t i = first; i < end; ++i) {
      ranks.doubled.push_back(static_cast<int>(first + 1 + end));
      ranks.positive.push_back(sorted[i] > 0);
    }
    first = end;
  }
  return ranks;
}

/// The probability that the sum of the ranks of random signs is `smaller` or less.
double exact_tail(const std::vector<int>& ranks, int smaller) {
  std::vector<double> chance(std::accumulate(ranks.begin(), ranks.end(), 0) + 1, 0.0);
  chance[0] = 1;
  int reached = 0;
  for (const int rank : ranks) {
    reached += rank;
    for (int sum = reached; sum >= 0; --sum) {
      chance[sum] = 0.5 * (chance[sum] + (sum >= rank ? chance[sum - rank] : 0.0));
    }
  }
  return std::accumulate(chance.begin(), chance.begin() + smaller + 1, 0.0);
}

double normal_tail(const std::vector<int>& ranks, int smaller) {
  double mean = 0;
  double variance = 0;
  for (const int rank : ranks) {
    mean += 0.5 * rank;
    variance += 0.25 * rank * rank;
  }
  return 0.5 * std::erfc((mean - smaller - 1) / std::sqrt(2 * variance));
}

/// The 97.5 % quantile of Student's t (Abramowitz and Stegun 26.7.5; exact for 1 and 2, within 1 %
/// from 3 degrees of freedom on).
double student_quantile(double degrees) {
  if (degrees <= 1) return 12.7062;
  if (degrees <= 2) return 4.3027;
  constexpr double z = 1.959964;
  const double z2 = z * z;
  const double g1 = z * (z2 + 1) / 4;
  const double g2 = z * (5 * z2 * z2 + 16 * z2 + 3) / 96;
  const double g3 = z * (3 * z2 * z2 * z2 + 19 * z2 * z2 + 17 * z2 - 15) / 384;
  return z + g1 / degrees + g2 / (degrees * degrees) + g3 / (degrees * degrees * degrees);
}

}  // namespace

double signed_rank_p(std::span<const double> differences) {
  const SignedRanks ranks = rank_differences(differences);
  if (ranks.doubled.empty()) return 1;
  int positive = 0;
  int all = 0;
  for (size_t i = 0; i < ranks.doubled.size(); ++i) {
    all += ranks.doubled[i];
    if (ranks.positive[i]) positive += ranks.doubled[i];
  }
  const int smaller = std::min(positive, all - positive);
  const double tail = ranks.doubled.size() <= exact_limit ? exact_tail(ranks.doubled, smaller)
                                                          : normal_tail(ranks.doubled, smaller);
  return std::min(1.0, 2 * tail);
}

std::vector<double> holm_adjust(std::span<const double> p_values) {
  std::vector<size_t> order(p_values.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::stable_sort(order, [&](size_t a, size_t b) { return p_values[a] < p_values[b]; });
  std::vector<double> adjusted(p_values.size());
  double largest = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    const double scaled = p_values[order[i]] * static_cast<double>(order.size() - i);
    largest = std::max(largest, std::min(1.0, scaled));
    adjusted[order[i]] = largest;
  }
  return adjusted;
}

MeanInterval mean_interval(std::span<const double> values) {
  MeanInterval result;
  const auto n = static_cast<double>(values.size());
  if (values.empty()) return result;
  for (const double value : values) result.mean += value / n;
  if (values.size() < 2) return result;
  double squares = 0;
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.stddev = std::sqrt(squares / (n - 1));
  result.half_95 = student_quantile(n - 1) * result.stddev / std::sqrt(n);
  return result;
}

}  // namespace relume

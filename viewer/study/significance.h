#pragma once

#include <span>
#include <vector>

namespace relume {

/// Two-sided p-value of Wilcoxon's signed-rank test (1945) that paired differences are symmetric
/// around 0: the probability of ranks as uneven as these or more. Zero differences do not count;
/// ties share their mean rank. Exact up to 200 differences, above by the normal approximation with
/// the correction for ties; 1 where none is left. Differences are finite.
double signed_rank_p(std::span<const double> differences);

/// p-values corrected for their number by Holm's step-down rule (1979), in the same order, <= 1:
/// those below a level are wrong together with at most that probability.
std::vector<double> holm_adjust(std::span<const double> p_values);

struct MeanInterval {
  double mean = 0;
  double stddev = 0;   ///< of the values, n - 1 in the divisor; 0 for fewer than two
  double half_95 = 0;  ///< half the 95 % confidence interval of the mean (Student's t)
};

/// Of finite values; zeros when there are none.
MeanInterval mean_interval(std::span<const double> values);

}  // namespace relume

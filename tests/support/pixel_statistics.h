#pragma once

#include <cstddef>
#include <span>
#include <vector>

// Statistical tests of whole images: is what a random method gives right on average? One
// probability for all pixels together, below 0.01 by chance once in a hundred tests.

namespace relume::test {

/// Mean and variance of every pixel over independent trials (Welford 1962).
class PixelMoments {
 public:
  /// One trial's value of each pixel. As many in every call.
  void add(std::span<const double> values);

  size_t trials() const { return trials_; }
  size_t pixels() const { return mean_.size(); }
  double mean(size_t pixel) const { return mean_[pixel]; }
  /// Of the mean, unbiased; 2 trials or more.
  double variance_of_mean(size_t pixel) const;

 private:
  size_t trials_ = 0;
  std::vector<double> mean_;
  std::vector<double> squares_;
};

/// Two-sided probability of Student's t as far from 0 as `t`, with `degrees` > 0 of freedom.
double student_p(double t, double degrees);

/// The probability that two methods of the same expectation differ as much as these: of the worst
/// pixel (Welch's t-test, corrected for their number after Sidak 1967) and of all together
/// (Stouffer's sum), twice the smaller. A pixel that never changes on either side counts where it
/// differs by more than `rounding`: then 0.
double p_of_difference(const PixelMoments& a, const PixelMoments& b, double rounding = 1e-6);

/// The same against known expectations.
double p_of_mean(const PixelMoments& a, std::span<const double> expected, double rounding = 1e-6);

/// The probability of counts as uneven as these where all bins are equally likely (chi-squared,
/// by Wilson and Hilferty's normal approximation), small for uneven ones only.
double p_of_even_counts(std::span<const size_t> counts);

}  // namespace relume::test

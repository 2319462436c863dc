#include "tests/support/pixel_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/check.h"

namespace relume::test {
namespace {

/// The continued fraction of the incomplete beta function (Abramowitz and Stegun 26.5.8), by
/// Lentz's method.
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  double c = 1;
  double d = 1 / std::max(std::abs(1 - (a + b) * x / (a + 1)), tiny);
  double result = d;
  for (int m = 1; m < 400; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double step : {even, odd}) {
      d = 1 / (1 + step * d);
      c = 1 + step / c;
      result *= c * d;
    }
    if (std::abs(c * d - 1) < 1e-12) break;
  }
  return result;
}

/// I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

double normal_p(double z) {
  return std::erfc(std::abs(z) / std::sqrt(2.0));
}

/// The tests of all pixels as one.
class Combined {
 public:
  void add(double difference, double variance, double degrees, double rounding) {
    if (variance <= 0) {
      if (std::abs(difference) > rounding) smallest_ = 0;
      return;
    }
    const double t = difference / std::sqrt(variance);
    smallest_ = std::min(smallest_, student_p(t, degrees));
    sum_ += t;
    sum_variance_ += degrees / (degrees - 2);
    ++count_;
  }

  double p() const {
    if (smallest_ == 0) return 0;
    if (count_ == 0) return 1;
    const double of_worst = -std::expm1(count_ * std::log1p(-std::min(smallest_, 1 - 1e-15)));
    return std::min(1.0, 2 * std::min(of_worst, normal_p(sum_ / std::sqrt(sum_variance_))));
  }

 private:
  double smallest_ = 1;
  double sum_ = 0;
  double sum_variance_ = 0;
  int count_ = 0;
};

}  // namespace

void PixelMoments::add(std::span<const double> values) {
  if (trials_ == 0) {
    mean_.assign(values.size(), 0);
    squares_.assign(values.size(), 0);
  }
  CHECK_MSG(values.size() == pixels(), "{} values", values.size());
  ++trials_;
  for (size_t i = 0; i < values.size(); ++i) {
    const double step = values[i] - mean_[i];
    mean_[i] += step / static_cast<double>(trials_);
    squares_[i] += step * (values[i] - mean_[i]);
  }
}

double PixelMoments::variance_of_mean(size_t pixel) const {
  const auto n = static_cast<double>(trials_);
  return squares_[pixel] / (n - 1) / n;
}

double student_p(double t, double degrees) {
  return incomplete_beta(degrees / 2, 0.5, degrees / (degrees + t * t));
}

double p_of_difference(const PixelMoments& a, const PixelMoments& b, double rounding) {
  Combined combined;
  for (size_t i = 0; i < a.pixels(); ++i) {
    const double from_a = a.variance_of_mean(i);
    const double from_b = b.variance_of_mean(i);
    const double variance = from_a + from_b;
    const double degrees = variance > 0
                               ? variance * variance /
                                     (from_a * from_a / static_cast<double>(a.trials() - 1) +
                                      from_b * from_b / static_cast<double>(b.trials() - 1))
                               : 1;
    combined.add(a.mean(i) - b.mean(i), variance, degrees, rounding);
  }
  return combined.p();
}

double p_of_mean(const PixelMoments& a, std::span<const double> expected, double rounding) {
  Combined combined;
  for (size_t i = 0; i < a.pixels(); ++i) {
    combined.add(a.mean(i) - expected[i], a.variance_of_mean(i),
                 static_cast<double>(a.trials() - 1), rounding);
  }
  return combined.p();
}

double p_of_even_counts(std::span<const size_t> counts) {
  const auto bins = static_cast<double>(counts.size());
  const double total =
      static_cast<double>(std::accumulate(counts.begin(), counts.end(), size_t{0}));
  const double expected = total / bins;
  double chi_squared = 0;
  for (const size_t count : counts) {
    const double off = static_cast<double>(count) - expected;
    chi_squared += off * off / expected;
  }
  const double degrees = bins - 1;
  const double spread = 2 / (9 * degrees);
  const double z = (std::cbrt(chi_squared / degrees) - (1 - spread)) / std::sqrt(spread);
  return 0.5 * std::erfc(z / std::sqrt(2.0));
}

}  // namespace relume::test

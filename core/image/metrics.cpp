#include "core/image/metrics.h"

#include <fmt/format.h>

#include <cmath>

#include "core/base/check.h"
#include "core/base/error.h"

namespace relume {
namespace {

/// Neumaier's compensated sum: the error does not grow with the number of terms.
class CompensatedSum {
 public:
  void add(double term) {
    const double sum = sum_ + term;
    compensation_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
    sum_ = sum;
  }
  double value() const { return sum_ + compensation_; }

 private:
  double sum_ = 0;
  double compensation_ = 0;
};

/// Below this a denominator of the relative error counts as this, so that a black reference gives a
/// large but finite value.
constexpr double smallest_denominator = 1e-12;

void require_same_size(const Image& image, const Image& reference) {
  CHECK_MSG(image.channels >= 3 && reference.channels >= 3, "channels {} and {}", image.channels,
            reference.channels);
  if (image.width == reference.width && image.height == reference.height) return;
  throw Error(ErrorKind::usage,
              fmt::format("cannot compare {} x {} with {} x {} pixels; give images of equal size",
                          image.width, image.height, reference.width, reference.height));
}

double squared_distance(const Image& image, const Image& reference, size_t pixel) {
  const dvec3 difference = dvec3(image.rgb(pixel)) - dvec3(reference.rgb(pixel));
  return glm::dot(difference, difference);
}

bool is_covered(const Image& image, const Image& reference, std::span<const float> coverage,
                size_t pixel) {
  if (!coverage.empty()) return coverage[pixel] > 0;
  return image.rgb(pixel) != vec3(0) || reference.rgb(pixel) != vec3(0);
}

double relative_error(const Image& image, const Image& reference, double reference_mean) {
  const double floor = 1e-2 * reference_mean * reference_mean;
  CompensatedSum sum;
  for (size_t pixel = 0; pixel < image.pixel_count(); ++pixel) {
    const dvec3 expected(reference.rgb(pixel));
    const dvec3 difference = dvec3(image.rgb(pixel)) - expected;
    for (size_t c = 0; c < 3; ++c) {
      const double denominator = std::max(expected[c] * expected[c] + floor, smallest_denominator);
      sum.add(difference[c] * difference[c] / denominator);
    }
  }
  return sum.value() / (3.0 * static_cast<double>(image.pixel_count()));
}

}  // namespace

ImageError compare_images(const Image& image, const Image& reference,
                          std::span<const float> coverage) {
  require_same_size(image, reference);
  CHECK_MSG(coverage.empty() || coverage.size() == image.pixel_count(), "{} values for {} pixels",
            coverage.size(), image.pixel_count());
  ImageError result;
  result.pixels = image.pixel_count();
  if (result.pixels == 0) return result;
  CompensatedSum all;
  CompensatedSum covered;
  CompensatedSum squares;
  CompensatedSum reference_sum;
  for (size_t pixel = 0; pixel < result.pixels; ++pixel) {
    const double square = squared_distance(image, reference, pixel);
    CHECK_MSG(std::isfinite(square), "pixel {} is not finite", pixel);
    const double error = std::sqrt(square / 3);
    all.add(error);
    squares.add(square);
    result.max_error = std::max(result.max_error, error);
    if (!is_covered(image, reference, coverage, pixel)) continue;
    ++result.covered_pixels;
    covered.add(error);
    const dvec3 expected(reference.rgb(pixel));
    reference_sum.add(expected.x + expected.y + expected.z);
  }
  const double pixels = static_cast<double>(result.pixels);
  result.error_image = all.value() / pixels;
  result.rmse = std::sqrt(squares.value() / (3 * pixels));
  if (result.covered_pixels > 0) {
    const double covered_pixels = static_cast<double>(result.covered_pixels);
    result.error_covered = covered.value() / covered_pixels;
    result.reference_mean = reference_sum.value() / (3 * covered_pixels);
  }
  result.relative_mse = relative_error(image, reference, result.reference_mean);
  return result;
}

Image error_image(const Image& image, const Image& reference) {
  require_same_size(image, reference);
  Image result(image.width, image.height, 1);
  for (size_t pixel = 0; pixel < result.pixel_count(); ++pixel) {
    result.pixels[pixel] =
        static_cast<float>(std::sqrt(squared_distance(image, reference, pixel) / 3));
  }
  return result;
}

double mean_covered(std::span<const float> values, std::span<const float> coverage) {
  CHECK_MSG(coverage.empty() || coverage.size() == values.size(), "{} values for {} pixels",
            values.size(), coverage.size());
  CompensatedSum sum;
  size_t pixels = 0;
  for (size_t i = 0; i < values.size(); ++i) {
    if (!coverage.empty() && !(coverage[i] > 0)) continue;
    sum.add(values[i]);
    ++pixels;
  }
  return pixels > 0 ? sum.value() / static_cast<double>(pixels) : 0;
}

}  // namespace relume

#include "viewer/study/visibility_error.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"

namespace relume {
namespace {

std::vector<double> gaussian_taps(double sigma_px) {
  const int radius = static_cast<int>(std::ceil(3 * sigma_px));
  std::vector<double> taps(static_cast<size_t>(radius) + 1);
  for (int i = 0; i <= radius; ++i) taps[i] = std::exp(-0.5 * i * i / (sigma_px * sigma_px));
  return taps;
}

/// One pass of a separable filter along lines of `count` values that lie `stride` apart.
void filter_line(const double* in, double* out, int count, size_t stride,
                 const std::vector<double>& taps) {
  const int radius = static_cast<int>(taps.size()) - 1;
  for (int i = 0; i < count; ++i) {
    double sum = 0;
    for (int j = std::max(0, i - radius); j <= std::min(count - 1, i + radius); ++j) {
      sum += taps[std::abs(i - j)] * in[j * stride];
    }
    out[i * stride] = sum;
  }
}

std::vector<double> filter(std::vector<double> values, int width, const std::vector<double>& taps) {
  const int height = static_cast<int>(values.size()) / width;
  std::vector<double> rows(values.size());
  for (int y = 0; y < height; ++y) {
    const size_t first = static_cast<size_t>(y) * width;
    filter_line(&values[first], &rows[first], width, 1, taps);
  }
  for (int x = 0; x < width; ++x) filter_line(&rows[x], &values[x], height, width, taps);
  return values;
}

}  // namespace

std::vector<double> blur_masked(std::span<const double> values, std::span<const float> counts,
                                int width, double sigma_px) {
  CHECK_MSG(values.size() == counts.size() && width > 0 && values.size() % width == 0, "{} {} {}",
            values.size(), counts.size(), width);
  const std::vector<double> taps = gaussian_taps(sigma_px);
  std::vector<double> masked(values.size());
  std::vector<double> mask(values.size());
  for (size_t i = 0; i < values.size(); ++i) {
    mask[i] = counts[i] > 0 ? 1 : 0;
    masked[i] = counts[i] > 0 ? values[i] : 0;
  }
  masked = filter(std::move(masked), width, taps);
  mask = filter(std::move(mask), width, taps);
  for (size_t i = 0; i < values.size(); ++i) masked[i] = counts[i] > 0 ? masked[i] / mask[i] : 0;
  return masked;
}

VisibilityError compare_visibility(std::span<const float> map, std::span<const float> truth,
                                   std::span<const float> counts, int width, double sigma_px) {
  CHECK_MSG(map.size() == truth.size() && map.size() == counts.size(), "{} {} {}", map.size(),
            truth.size(), counts.size());
  std::vector<double> difference(map.size());
  for (size_t i = 0; i < map.size(); ++i) difference[i] = double{map[i]} - truth[i];
  const std::vector<double> low = blur_masked(difference, counts, width, sigma_px);
  VisibilityError error;
  double pixels = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    if (!(counts[i] > 0)) continue;
    error.mae += std::abs(difference[i]);
    error.bias += std::abs(low[i]);
    error.noise += std::abs(difference[i] - low[i]);
    ++pixels;
  }
  const double scale = pixels > 0 ? 1 / pixels : 0;
  return {error.mae * scale, error.bias * scale, error.noise * scale};
}

double mean_absolute_difference(std::span<const float> a, std::span<const float> b,
                                std::span<const float> counts) {
  CHECK_MSG(a.size() == b.size() && a.size() == counts.size(), "{} {} {}", a.size(), b.size(),
            counts.size());
  double sum = 0;
  double pixels = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    if (!(counts[i] > 0)) continue;
    sum += std::abs(double{a[i]} - b[i]);
    ++pixels;
  }
  return pixels > 0 ? sum / pixels : 0;
}

}  // namespace relume

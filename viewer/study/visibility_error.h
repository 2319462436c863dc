#pragma once

#include <span>
#include <vector>

namespace relume {

/// How far a map of visibility is from the truth, over the pixels that count.
struct VisibilityError {
  double mae = 0;    ///< mean |d|, d = map - truth
  double bias = 0;   ///< mean |G(d)|: what is left at low frequencies
  double noise = 0;  ///< mean |d - G(d)|: what is left at high frequencies
};

/// Maps are row-major and `width` wide; pixels whose `counts` is 0 do not count. G is a Gaussian of
/// standard deviation `sigma_px` pixels, cut at three of them, whose weights are normalised over
/// the pixels that count. All zero when no pixel counts.
VisibilityError compare_visibility(std::span<const float> map, std::span<const float> truth,
                                   std::span<const float> counts, int width, double sigma_px = 3);

/// `values` filtered by the same G.
std::vector<double> blur_masked(std::span<const double> values, std::span<const float> counts,
                                int width, double sigma_px);

/// Mean over the pixels that count of |a - b|; 0 when none does.
double mean_absolute_difference(std::span<const float> a, std::span<const float> b,
                                std::span<const float> counts);

}  // namespace relume

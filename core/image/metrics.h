#pragma once

#include "core/image/image.h"

namespace relume {

/// How far an image is from a reference. All values are in the images' own linear units.
struct ImageError {
  double error_image = 0;  ///< TR2007-600 eq. 7: mean over all pixels of the per-pixel RMS over RGB
  double error_covered = 0;   ///< eq. 7 over covered pixels only (0 when there are none)
  double rmse = 0;            ///< root of the mean squared error over all pixels and channels
  double relative_mse = 0;    ///< mean of d^2 / max(1e-12, reference^2 + 1e-2 reference_mean^2)
  double reference_mean = 0;  ///< mean of the reference over covered pixels and RGB
  double max_error = 0;       ///< largest per-pixel RMS
  size_t covered_pixels = 0;  ///< pixels with coverage > 0
  size_t pixels = 0;
};

/// Compares the first three channels. `coverage` is empty (every pixel in which either image is
/// non-zero counts as covered) or one value a pixel. Throws Error(usage) when sizes differ. Sums
/// are compensated, in row order.
ImageError compare_images(const Image& image, const Image& reference,
                          std::span<const float> coverage = {});

/// Per-pixel RMS over RGB of image - reference (eq. 7 before the mean): one channel.
Image error_image(const Image& image, const Image& reference);

/// Mean of `values`, one a pixel, over the pixels whose `coverage` is > 0; 0 when there are none.
/// Empty coverage: over all pixels.
double mean_covered(std::span<const float> values, std::span<const float> coverage);

}  // namespace relume

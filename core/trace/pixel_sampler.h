#pragma once

#include <vector>

#include "core/base/random.h"
#include "core/math/vec.h"

namespace relume {

/// The strata of one pixel: `spp` cells of equal area, in scanline order. Row r holds columns[r]
/// cells and is columns[r] / spp high. Numbers with a divisor pair of aspect <= 2 give a full grid
/// (25 = 5 x 5, 8 = 4 x 2, 2 = 2 x 1); others give rows of unequal length (7 = 2 + 2 + 3).
struct PixelStrata {
  int spp = 1;
  std::vector<int> columns;
};

/// spp in [1, 4096].
PixelStrata make_pixel_strata(int spp);

/// One jittered position a cell, in [0, 1)^2 of the pixel, appended to `positions` in scanline
/// order: a function of (seed, pixel) alone.
void sample_pixel(const PixelStrata& strata, uint64_t seed, uint64_t pixel,
                  std::vector<vec2>& positions);

}  // namespace relume

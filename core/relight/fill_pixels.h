#pragma once

#include "core/relight/kernel.h"

namespace relume {

/// Completes a tile of which only the first `shaded` blocks are known. A pixel of another block
/// becomes its coverage times the radiance of what covers its known neighbours: the sum of their
/// values over the sum of their coverages, of the up to eight around it within the tile, or of the
/// whole tile where those are empty. `sums` holds the tile's blocks; finite, and stays so.
void fill_pixels(const RelightCache& cache, const PackedTile& tile, int shaded, float* sums);

}  // namespace relume

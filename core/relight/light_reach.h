#pragma once

#include <vector>

#include "core/math/vec.h"
#include "core/samples/relight_cache.h"
#include "core/shade/kernel_light.h"

namespace relume {

/// Bounds of the records of each tile, world; empty bounds where a tile has none.
std::vector<Bounds> tile_bounds(const RelightCache& cache);

/// False for lights that reach everything.
bool may_miss(const KernelLight& light);

/// False only when the light gives exactly nothing to every point of `bounds`: they lie beyond
/// its range, or the cone of a spot passes them by.
bool can_reach(const KernelLight& light, const Bounds& bounds);

}  // namespace relume

#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// What kernels made for what a scene requires save, least of `repeats`, both sides in turn:
///   only-diffuse   the cache's diffuse part (make_diffuse_cache) as Lambert records; beside it as
///                  Phong records without specular: general_ms
///   shadows-off    a light without shadows; beside it with a visibility of 1 everywhere
///   lights-in-one-pass  four lights that move at once; beside it four times one light
///   without-footprints  a cache of the same records alone; beside it this one, where it has
///                  footprints for shadows and at most 8 million records
/// Each holds ms, general_ms and ratio, ms / general_ms.
std::vector<FigureRow> bench_savings(const RelightCache& cache, int repeats);

}  // namespace relume

#pragma once

#include <vector>

#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"

namespace relume::test {

/// One record a pixel and type, at its first sample, that knows `stored` of its samples.
RelightCache make_merged_cache(const Scene& scene, const Tracer& tracer, int spp, int stored,
                               uint64_t seed = 1);

/// Per pixel: sum over records of weight times visibility. `source` knows the cache's receivers by
/// index.
std::vector<double> pixel_visibility(const RelightCache& cache, VisibilitySource& source,
                                     const Light& light);

}  // namespace relume::test

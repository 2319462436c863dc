#pragma once

#include <vector>

#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// The fraction of each pixel's samples that see the light `source` was made ready for: the mean of
/// its records' visibility, weighted by their weights, unshaded. Row-major, in [0, 1]; 0 where a
/// pixel has no records. Packed formats keep no weights: there every record counts alike. All
/// threads; bit-equal for any number of them.
std::vector<float> pixel_visibility(const RelightCache& cache, const VisibilitySource& source);

/// Asks `source` for every record of the cache with all threads and throws the answers away: what a
/// light move costs beside prepare(). Returns the number of slots asked, 16 receivers each.
uint64_t query_cache(const RelightCache& cache, const VisibilitySource& source);

}  // namespace relume

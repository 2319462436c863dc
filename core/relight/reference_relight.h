#pragma once

#include "core/image/image.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// The layer of `light` (weight 1) from the same records as relight(), in plain scalar double
/// arithmetic on one thread, written apart from the kernels: what tests and `bench` hold them
/// against. `shadows`, if any, must be prepared for the light.
Image reference_layer(const RelightCache& cache, const Light& light,
                      const VisibilitySource* shadows);

}  // namespace relume

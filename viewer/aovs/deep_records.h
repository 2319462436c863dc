#pragma once

#include <span>

#include "core/image/deep_io.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// The records of a cache as deep pixels, nearest first (docs/frame-format.md): colour under
/// `lights` and A, such that any flatten gives the frame and its coverage; depth Z, weight, shader
/// id and the fields of the records. Colours are within 2^-11 of the double reference (each, and of
/// their weighted sum), beyond half floats' range cut. `shadows` null: everything is visible.
/// Throws Error(input) for caches in packed formats, which keep no weights.
DeepImage make_deep_records(const RelightCache& cache, std::span<const Light> lights,
                            VisibilitySource* shadows);

}  // namespace relume

#pragma once

#include "core/math/vec.h"
#include "core/samples/sample_type.h"

namespace relume {

/// Below this fraction of the scene's radius, distances to a light are clamped, so that a light
/// that touches a record stays finite (kernels and reference alike).
inline constexpr double min_light_distance = 1e-3;

/// Radiance that one record sends to the eye under `light` at weight 1, without visibility: plain
/// double arithmetic, written apart from the kernels, which are tested against it. `vector` is one
/// sample vector of `type`; eye in world space; `scene_radius` in world units.
dvec3 reference_response(const SampleType& type, const float* vector, const Light& light, dvec3 eye,
                         double scene_radius);

}  // namespace relume

#pragma once

#include <utility>

#include "core/scene/light.h"

namespace relume {

/// How a light reaches a record; each has kernels of its own, so that a scene pays for what it
/// uses.
enum class LightKernel : int {
  point,
  point_constant,
  point_range,
  spot,
  spot_constant,
  spot_range,
  directional,
  count
};

/// All kinds, for tables of kernels.
using LightKernels = std::make_integer_sequence<int, static_cast<int>(LightKernel::count)>;

/// What a kind reads and computes.
constexpr bool is_spot(LightKernel kind) {
  return kind == LightKernel::spot || kind == LightKernel::spot_constant ||
         kind == LightKernel::spot_range;
}
constexpr bool has_range(LightKernel kind) {
  return kind == LightKernel::point_range || kind == LightKernel::spot_range;
}
constexpr bool has_falloff(LightKernel kind) {
  return kind == LightKernel::point || kind == LightKernel::spot || has_range(kind);
}

/// A light as kernels see it: plain floats, world space.
struct KernelLight {
  LightKernel kind = LightKernel::point;
  float position[3] = {};
  float to_light[3] = {};  ///< unit, directional: towards the light; spot: -axis
  float cos_outer = 0;
  float inverse_cos_range = 0;  ///< 1 / (cos_inner - cos_outer)
  float inverse_range_squared = 0;
  float min_distance_squared = 0;  ///< distances below are clamped: no singularity at the light
};

/// `scene_radius` in world units: see min_light_distance in core/shade/reference.h.
KernelLight make_kernel_light(const Light& light, float scene_radius);

}  // namespace relume

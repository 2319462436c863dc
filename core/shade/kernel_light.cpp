#include "core/shade/kernel_light.h"

#include "core/shade/reference.h"

namespace relume {
namespace {

LightKernel kernel_kind(const Light& light) {
  const bool ends = is_finite(reach_of(light));
  switch (light.type) {
    case LightType::point:
      if (ends) return LightKernel::point_range;
      return light.falloff ? LightKernel::point : LightKernel::point_constant;
    case LightType::spot:
      if (ends) return LightKernel::spot_range;
      return light.falloff ? LightKernel::spot : LightKernel::spot_constant;
    case LightType::directional:
      return LightKernel::directional;
  }
  return LightKernel::point;
}

}  // namespace

KernelLight make_kernel_light(const Light& light, float scene_radius) {
  KernelLight kernel;
  kernel.kind = kernel_kind(light);
  const vec3 to_light = -normalize_or(light.direction, vec3(0, -1, 0));
  for (int i = 0; i < 3; ++i) {
    kernel.position[i] = light.position[i];
    kernel.to_light[i] = to_light[i];
  }
  // A cone whose edge is sharper than float cosines resolve becomes a step of that width.
  kernel.cos_outer = std::cos(radians_from_degrees(light.outer_angle_deg));
  const float range = std::cos(radians_from_degrees(light.inner_angle_deg)) - kernel.cos_outer;
  kernel.inverse_cos_range = 1.0f / std::max(range, 1e-6f);
  kernel.inverse_range_squared = 1.0f / (reach_of(light) * reach_of(light));
  const float closest = static_cast<float>(min_light_distance) * scene_radius;
  kernel.min_distance_squared = std::max(closest * closest, 1e-36f);
  return kernel;
}

}  // namespace relume

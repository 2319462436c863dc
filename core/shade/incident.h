#pragma once

// Part of the kernel sources: see core/simd/pack.h for what may be called here.

#include "core/shade/kernel_light.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

using F = Pack<native_width>;
using V = Vec3<F>;

/// One light a lane; block kernels broadcast one light to all.
struct LightPack {
  V position;
  V to_light;
  F cos_outer;
  F inverse_cos_range;
  F inverse_range_squared;
  F min_distance_squared;
};

inline LightPack broadcast(const KernelLight& light) {
  return {{F(light.position[0]), F(light.position[1]), F(light.position[2])},
          {F(light.to_light[0]), F(light.to_light[1]), F(light.to_light[2])},
          F(light.cos_outer),
          F(light.inverse_cos_range),
          F(light.inverse_range_squared),
          F(light.min_distance_squared)};
}

/// Direction to the light and irradiance on a plane that faces it, per unit weight.
struct Incident {
  V wi;
  F irradiance;
};

template <LightKernel kind>
Incident incident(const LightPack& light, V p) {
  if constexpr (kind == LightKernel::directional) {
    return {light.to_light, F(1)};
  } else {
    const V d{light.position.x - p.x, light.position.y - p.y, light.position.z - p.z};
    const F distance_squared = min(max(dot(d, d), light.min_distance_squared), F(1e36f));
    const F inverse_distance = rsqrt(distance_squared);
    const V wi = d * inverse_distance;
    F irradiance = has_falloff(kind) ? inverse_distance * inverse_distance : F(1);
    if constexpr (has_range(kind)) {
      const F part = distance_squared * light.inverse_range_squared;
      irradiance = irradiance * max(F(1) - part * part, F(0));
    }
    if constexpr (is_spot(kind)) {
      const F t = min(
          max((dot(wi, light.to_light) - light.cos_outer) * light.inverse_cos_range, F(0)), F(1));
      irradiance = irradiance * t * t * (F(3) - F(2) * t);
    }
    return {wi, irradiance};
  }
}

/// Unit vector from p to `target`; any vector when they coincide.
inline V direction_to(V target, V p) {
  const V d{target.x - p.x, target.y - p.y, target.z - p.z};
  return d * rsqrt(min(max(dot(d, d), F(1e-36f)), F(1e36f)));
}

}  // namespace relume::RELUME_ISA

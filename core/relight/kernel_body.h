#pragma once

// The one kernel source: included by one tiny source file per instruction set, which defines
// RELUME_ISA. Pure functions on flat arrays; no std:: or glm:: calls (see core/simd/pack.h).

#include "core/relight/kernel.h"
#include "core/shade/shader_list.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

inline constexpr int lanes = 16;  // block_lanes of core/samples/relight_cache.h

using F = Pack<native_width>;
using V = Vec3<F>;

/// Direction to the light and irradiance on a plane that faces it, per unit weight.
struct Incident {
  V wi;
  F irradiance;
};

template <LightKernel kind>
Incident incident(const KernelLight& light, V p) {
  if constexpr (kind == LightKernel::directional) {
    return {{F(light.to_light[0]), F(light.to_light[1]), F(light.to_light[2])}, F(1)};
  } else {
    const V d{F(light.position[0]) - p.x, F(light.position[1]) - p.y, F(light.position[2]) - p.z};
    const F distance_squared = min(max(dot(d, d), F(light.min_distance_squared)), F(1e36f));
    const F inverse_distance = rsqrt(distance_squared);
    const V wi = d * inverse_distance;
    constexpr bool falloff = kind == LightKernel::point || kind == LightKernel::spot;
    F irradiance = falloff ? inverse_distance * inverse_distance : F(1);
    if constexpr (kind == LightKernel::spot || kind == LightKernel::spot_constant) {
      const V axis{F(light.to_light[0]), F(light.to_light[1]), F(light.to_light[2])};
      const F t = min(max((dot(wi, axis) - F(light.cos_outer)) * F(light.inverse_cos_range), F(0)),
                      F(1));
      irradiance = irradiance * t * t * (F(3) - F(2) * t);
    }
    return {wi, irradiance};
  }
}

/// Shades `slots` slots of one shader and adds them to rgb, lane by lane in slot order.
template <class Shader, LightKernel kind, bool shadowed>
void shade_slots(const float* data, const float* visibility, int slots, int width, const float* eye,
                 const KernelLight& light, float* rgb) {
  const int slot_floats = (1 + width) * lanes;
  for (int lane = 0; lane < lanes; lane += native_width) {
    F red = F::load(rgb + lane);
    F green = F::load(rgb + lanes + lane);
    F blue = F::load(rgb + 2 * lanes + lane);
    for (int slot = 0; slot < slots; ++slot) {
      const float* base = data + static_cast<int64_t>(slot) * slot_floats + lane;
      const auto field = [base](int i) { return F::load(base + (1 + i) * lanes); };
      const V p{field(0), field(1), field(2)};
      const Incident in = incident<kind>(light, p);
      const V to_eye{F(eye[0]) - p.x, F(eye[1]) - p.y, F(eye[2]) - p.z};
      const V wo = to_eye * rsqrt(min(max(dot(to_eye, to_eye), F(1e-36f)), F(1e36f)));
      F scale = F::load(base) * in.irradiance;
      if constexpr (shadowed) scale = scale * F::load(visibility + slot * lanes + lane);
      const V response = Shader::template kernel<F>(field, in.wi, wo);
      red = fma(response.x, scale, red);
      green = fma(response.y, scale, green);
      blue = fma(response.z, scale, blue);
    }
    red.store(rgb + lane);
    green.store(rgb + lanes + lane);
    blue.store(rgb + 2 * lanes + lane);
  }
}

using ShadeSlots = void (*)(const float*, const float*, int, int, const float*, const KernelLight&,
                            float*);

struct ShaderKernels {
  ShadeSlots by_light[static_cast<int>(LightKernel::count)][2];  // [kind][shadowed]
};

template <class Shader>
constexpr ShaderKernels kernels_of() {
  using K = LightKernel;
  return {{{shade_slots<Shader, K::point, false>, shade_slots<Shader, K::point, true>},
           {shade_slots<Shader, K::point_constant, false>,
            shade_slots<Shader, K::point_constant, true>},
           {shade_slots<Shader, K::spot, false>, shade_slots<Shader, K::spot, true>},
           {shade_slots<Shader, K::spot_constant, false>,
            shade_slots<Shader, K::spot_constant, true>},
           {shade_slots<Shader, K::directional, false>,
            shade_slots<Shader, K::directional, true>}}};
}

template <class... Shaders>
const ShaderKernels* kernel_table(ShaderList<Shaders...>) {
  static constexpr ShaderKernels table[] = {kernels_of<Shaders>()...};
  return table;
}

void shade_block(const KernelBlock& block, const KernelLight& light) {
  const ShaderKernels* const table = kernel_table(AllShaders{});
  const float* data = block.data;
  const float* visibility = block.visibility;
  for (int i = 0; i < 3 * lanes; ++i) block.rgb[i] = 0;
  for (int type = 0; type < block.type_count; ++type) {
    const int slots = block.slots[type];
    if (slots == 0) continue;
    const int width = block.widths[type];
    table[block.shaders[type]].by_light[static_cast<int>(light.kind)][visibility != nullptr](
        data, visibility, slots, width, block.eye, light, block.rgb);
    data += static_cast<int64_t>(slots) * (1 + width) * lanes;
    if (visibility != nullptr) visibility += slots * lanes;
  }
}

}  // namespace relume::RELUME_ISA

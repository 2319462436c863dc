#pragma once

// The one kernel source: included by one tiny source file per instruction set, which defines
// RELUME_ISA. Pure functions on flat arrays; no std:: or glm:: calls (see core/simd/pack.h).

#include "core/relight/kernel.h"
#include "core/shade/incident.h"
#include "core/shade/shader_list.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

inline constexpr int lanes = 16;  // block_lanes of core/samples/relight_cache.h

/// Radiance towards wo per unit irradiance: the lobes times their colours.
template <class Shader, class Load>
V respond(const Load& field, V wi, V wo) {
  const auto lobes = Shader::template lobes<F>(field, wi, wo);
  V sum{F(0), F(0), F(0)};
  int k = 0;
  for (const int color : Shader::colors) {
    const F lobe = lobes.value[k++];
    sum = {fma(field(color), lobe, sum.x), fma(field(color + 1), lobe, sum.y),
           fma(field(color + 2), lobe, sum.z)};
  }
  return sum;
}

/// Shades `slots` slots of one shader and adds them to rgb, lane by lane in slot order.
template <class Shader, LightKernel kind, bool shadowed>
void shade_slots(const float* data, const float* visibility, int slots, int width, const float* eye,
                 const KernelLight& light, float* rgb) {
  const int slot_floats = (1 + width) * lanes;
  const LightPack light_pack = broadcast(light);
  for (int lane = 0; lane < lanes; lane += native_width) {
    F red = F::load(rgb + lane);
    F green = F::load(rgb + lanes + lane);
    F blue = F::load(rgb + 2 * lanes + lane);
    for (int slot = 0; slot < slots; ++slot) {
      const float* base = data + static_cast<int64_t>(slot) * slot_floats + lane;
      const auto field = [base](int i) { return F::load(base + (1 + i) * lanes); };
      const V p{field(0), field(1), field(2)};
      const Incident in = incident<kind>(light_pack, p);
      const V wo = direction_to(V{F(eye[0]), F(eye[1]), F(eye[2])}, p);
      F scale = F::load(base) * in.irradiance;
      if constexpr (shadowed) scale = scale * F::load(visibility + slot * lanes + lane);
      const V response = respond<Shader>(field, in.wi, wo);
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
  return {
      {{shade_slots<Shader, K::point, false>, shade_slots<Shader, K::point, true>},
       {shade_slots<Shader, K::point_constant, false>,
        shade_slots<Shader, K::point_constant, true>},
       {shade_slots<Shader, K::spot, false>, shade_slots<Shader, K::spot, true>},
       {shade_slots<Shader, K::spot_constant, false>, shade_slots<Shader, K::spot_constant, true>},
       {shade_slots<Shader, K::directional, false>, shade_slots<Shader, K::directional, true>}}};
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

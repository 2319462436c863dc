#pragma once

// One sample vector under many lights, a light a lane: included by one tiny source file per
// instruction set, which defines RELUME_ISA. No std:: or glm:: calls (see core/simd/pack.h).

#include "core/shade/incident.h"
#include "core/shade/lobe_kernel.h"
#include "core/shade/shader_list.h"
#include "core/simd/dual.h"

namespace relume::RELUME_ISA {

using D = Dual<F>;

template <LightKernel kind>
LightPack load_lights(const KernelLightGroup& group, int first, float min_distance_squared) {
  const auto load3 = [first](const float* const* p) {
    return V{F::load(p[0] + first), F::load(p[1] + first), F::load(p[2] + first)};
  };
  LightPack light{};
  light.min_distance_squared = F(min_distance_squared);
  if constexpr (kind != LightKernel::directional) light.position = load3(group.position);
  if constexpr (is_spot(kind) || kind == LightKernel::directional) {
    light.to_light = load3(group.to_light);
  }
  if constexpr (has_range(kind)) {
    light.inverse_range_squared = F::load(group.inverse_range_squared + first);
  }
  if constexpr (is_spot(kind)) {
    light.cos_outer = F::load(group.cos_outer + first);
    light.inverse_cos_range = F::load(group.inverse_cos_range + first);
  }
  return light;
}

template <class Shader, LightKernel kind>
void store_lobes(const LobeQuery& query, const KernelLightGroup& group) {
  const float* v = query.vector;
  const V p{F(v[0]), F(v[1]), F(v[2])};
  const V wo = direction_to(V{F(query.eye[0]), F(query.eye[1]), F(query.eye[2])}, p);
  const auto field = [v](int i) { return F(v[i]); };
  for (int first = 0; first < group.count; first += native_width) {
    const Incident in =
        incident<kind>(load_lights<kind>(group, first, query.min_distance_squared), p);
    const auto lobes = Shader::template lobes<F>(field, in.wi, wo);
    float* out = query.out + first;
    for (const F value : lobes.value) {
      (value * in.irradiance).store(out);
      out += query.lobe_stride;
    }
  }
}

template <class Shader, LightKernel kind>
void store_derivatives(const LobeQuery& query, const KernelLightGroup& group) {
  const float* v = query.vector;
  const V p{F(v[0]), F(v[1]), F(v[2])};
  const V wo_value = direction_to(V{F(query.eye[0]), F(query.eye[1]), F(query.eye[2])}, p);
  const Vec3<D> wo{D(wo_value.x), D(wo_value.y), D(wo_value.z)};
  const auto field = [v, &query](int i) {
    const int axis = i - query.direction;
    if (axis >= 0 && axis < 3) {
      return D(F(v[i]), F(query.tangents[0][axis]), F(query.tangents[1][axis]), F(0));
    }
    return D(F(v[i]), F(0), F(0), F(i == query.scalar ? v[i] : 0.0f));
  };
  for (int first = 0; first < group.count; first += native_width) {
    const Incident in =
        incident<kind>(load_lights<kind>(group, first, query.min_distance_squared), p);
    const Vec3<D> wi{D(in.wi.x), D(in.wi.y), D(in.wi.z)};
    const auto lobes = Shader::template lobes<D>(field, wi, wo);
    float* out = query.out + first;
    for (const D& value : lobes.value) {
      (value.value * in.irradiance).store(out);
      (value.d0 * in.irradiance).store(out + query.derivative_stride);
      (value.d1 * in.irradiance).store(out + 2 * query.derivative_stride);
      (value.d2 * in.irradiance).store(out + 3 * query.derivative_stride);
      out += query.lobe_stride;
    }
  }
}

using LobeFunction = void (*)(const LobeQuery&, const KernelLightGroup&);

struct LobeTable {
  LobeFunction lobes[static_cast<int>(LightKernel::count)];
  LobeFunction derivatives[static_cast<int>(LightKernel::count)];
};

template <class S, int... kinds>
constexpr LobeTable lobe_table_of(std::integer_sequence<int, kinds...>) {
  return {{store_lobes<S, static_cast<LightKernel>(kinds)>...},
          {store_derivatives<S, static_cast<LightKernel>(kinds)>...}};
}

template <class... Shaders>
const LobeTable& lobe_table(ShaderList<Shaders...>, int shader) {
  static constexpr LobeTable table[] = {lobe_table_of<Shaders>(LightKernels{})...};
  return table[shader];
}

LobeKernels make_lobe_kernels() {
  return {
      [](const LobeQuery& query, const KernelLightGroup& group) {
        lobe_table(AllShaders{}, query.shader).lobes[static_cast<int>(group.kind)](query, group);
      },
      [](const LobeQuery& query, const KernelLightGroup& group) {
        lobe_table(AllShaders{}, query.shader)
            .derivatives[static_cast<int>(group.kind)](query, group);
      }};
}

}  // namespace relume::RELUME_ISA

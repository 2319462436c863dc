#include "core/shade/light_matrix.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/shade/shader_list.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

constexpr int group_lights = 16;

template <class... Shaders>
std::span<const int> colors_of(ShaderList<Shaders...>, const ShaderInfo* shader) {
  std::span<const int> colors;
  ((shader == &Shaders::info ? (colors = Shaders::colors, 0) : 0), ...);
  return colors;
}

void append_column(LightSet& set, const Light& light, const KernelLight& kernel, bool padding) {
  set.lights.push_back(light);
  set.padding.push_back(padding);
  const vec3 weight = padding ? vec3(0) : light.weight();
  for (int c = 0; c < 3; ++c) {
    set.weights[c].push_back(weight[c]);
    set.arrays[c].push_back(kernel.position[c]);
    set.arrays[3 + c].push_back(kernel.to_light[c]);
  }
  set.arrays[6].push_back(kernel.cos_outer);
  set.arrays[7].push_back(kernel.inverse_cos_range);
  set.arrays[8].push_back(kernel.inverse_range_squared);
}

}  // namespace

LightSet make_light_set(std::span<const Light> lights, float scene_radius) {
  LightSet set;
  set.light_count = static_cast<int>(lights.size());
  for (int kind = 0; kind < static_cast<int>(LightKernel::count); ++kind) {
    const Light* last = nullptr;
    for (const Light& light : lights) {
      const KernelLight kernel = make_kernel_light(light, scene_radius);
      set.min_distance_squared = kernel.min_distance_squared;
      if (static_cast<int>(kernel.kind) != kind) continue;
      append_column(set, light, kernel, false);
      last = &light;
    }
    while (last != nullptr && set.columns() % group_lights != 0) {
      append_column(set, *last, make_kernel_light(*last, scene_radius), true);
    }
    set.kinds.resize(static_cast<size_t>(set.columns()) / group_lights,
                     static_cast<LightKernel>(kind));
  }
  return set;
}

LobeEvaluator::LobeEvaluator(std::span<const SampleType> types, const LightSet& lights, vec3 eye,
                             InstructionSet set)
    : lights_(&lights),
      eye_{eye.x, eye.y, eye.z},
      kernels_(lobe_kernels(choose_instruction_set(set))) {
  const auto table = shader_table();
  for (const SampleType& type : types) {
    Shape& shape = shapes_.emplace_back();
    shape.width = type.width;
    const auto found = std::find(table.begin(), table.end(), type.shader);
    CHECK(found != table.end());
    shape.shader = static_cast<int>(found - table.begin());
    for (const int color : colors_of(AllShaders{}, type.shader)) {
      shape.colors[shape.lobe_count++] = color;
    }
    for (size_t f = 0; f < type.field_count(); ++f) {
      const SampleField& field = type.field(f);
      const bool is_direction = field.kind == FieldKind::direction || field.kind == FieldKind::axis;
      if (is_direction) {
        shape.direction = type.offsets[f];
        shape.is_axis = field.kind == FieldKind::axis;
      }
      if (field.kind == FieldKind::scalar && field.source == FieldSource::material) {
        shape.scalar = type.offsets[f];
        shape.largest_scalar = field.high;
      }
    }
  }
}

void LobeEvaluator::lobes(int type, const float* vector, float* out) const {
  const Shape& shape = shapes_[type];
  const int columns = lights_->columns();
  LobeQuery query{shape.shader, vector,  eye_, lights_->min_distance_squared, -1, -1, {},
                  out,          columns, 0};
  for (int first = 0; first < columns; first += group_lights) {
    const auto& a = lights_->arrays;
    query.out = out + first;
    kernels_.lobes(query, {lights_->kinds[first / group_lights],
                           group_lights,
                           {&a[0][first], &a[1][first], &a[2][first]},
                           {&a[3][first], &a[4][first], &a[5][first]},
                           &a[6][first],
                           &a[7][first],
                           &a[8][first]});
  }
}

void LobeEvaluator::lobes_and_derivatives(int type, const float* vector, vec3 tangent0,
                                          vec3 tangent1, float* out) const {
  const Shape& shape = shapes_[type];
  const int columns = lights_->columns();
  const float t0[3] = {tangent0.x, tangent0.y, tangent0.z};
  const float t1[3] = {tangent1.x, tangent1.y, tangent1.z};
  LobeQuery query{shape.shader,    vector,       eye_,     lights_->min_distance_squared,
                  shape.direction, shape.scalar, {t0, t1}, out,
                  4 * columns,     columns};
  for (int first = 0; first < columns; first += group_lights) {
    const auto& a = lights_->arrays;
    query.out = out + first;
    kernels_.lobes_and_derivatives(query, {lights_->kinds[first / group_lights],
                                           group_lights,
                                           {&a[0][first], &a[1][first], &a[2][first]},
                                           {&a[3][first], &a[4][first], &a[5][first]},
                                           &a[6][first],
                                           &a[7][first],
                                           &a[8][first]});
  }
}

void shade_rows(const LobeEvaluator& evaluator, int type, const float* vectors, int rows,
                const float* lobes, float* v) {
  const LightSet& lights = evaluator.lights();
  const int columns = lights.columns();
  for (int row = 0; row < rows; ++row) {
    for (int c = 0; c < 3; ++c) {
      float* out = v + (static_cast<size_t>(row) * 3 + c) * columns;
      std::fill(out, out + columns, 0.0f);
      for (int k = 0; k < evaluator.lobe_count(type); ++k) {
        const float color = vectors[evaluator.color_offset(type, k) + c];
        const float* lobe = lobes + (static_cast<size_t>(row) * max_lobes + k) * columns;
        for (int j = 0; j < columns; ++j) out[j] += color * lobe[j] * lights.weights[c][j];
      }
    }
    vectors += evaluator.vector_width(type);
  }
}

}  // namespace relume

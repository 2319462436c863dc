#include "core/samples/sample_type.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/check.h"
#include "core/base/error.h"

namespace relume {
namespace {

SampleType apply_merges(SampleType type, const Material& material) {
  for (const auto& [field, merge] : material.merges) {
    for (size_t i = 0; i < type.field_count(); ++i) {
      if (type.field(i).name == field) type.merges[i] = merge;
    }
  }
  return type;
}

}  // namespace

int field_offset(const SampleType& type, FieldSource source) {
  for (size_t i = 0; i < type.field_count(); ++i) {
    if (type.field(i).source == source) return type.offsets[i];
  }
  return -1;
}

SampleType make_sample_type(const ShaderInfo& shader) {
  SampleType type;
  type.name = shader.name;
  type.shader = &shader;
  for (const SampleField& field : shader.fields) {
    CHECK_MSG(field.width == 1 || field.width == 3, "field {} width {}", field.name, field.width);
    type.merges.push_back(field.merge);
    type.offsets.push_back(type.width);
    type.width += field.width;
  }
  return type;
}

SampleTypes make_sample_types(const Scene& scene) {
  SampleTypes result;
  for (const Material& material : scene.materials) {
    const SampleType type =
        apply_merges(make_sample_type(*scene.shaders[material.shader]), material);
    const auto same = [&](const SampleType& other) {
      return other.shader == type.shader && other.merges == type.merges;
    };
    const auto found = std::find_if(result.types.begin(), result.types.end(), same);
    result.type_of_material.push_back(static_cast<uint16_t>(found - result.types.begin()));
    if (found != result.types.end()) continue;
    if (result.types.size() == max_sample_types) {
      throw limit_error(scene.name,
                        fmt::format("needs more than {} sample types", max_sample_types),
                        "use fewer different merge choices");
    }
    result.types.push_back(type);
    const auto of_shader =
        std::count_if(result.types.begin(), result.types.end(),
                      [&](const SampleType& other) { return other.shader == type.shader; });
    if (of_shader > 1) result.types.back().name = fmt::format("{}#{}", type.name, of_shader);
  }
  return result;
}

}  // namespace relume

#include "viewer/aovs/channel_names.h"

#include <algorithm>

#include "core/shade/shaders.h"

namespace relume {

std::string layer_of(const SampleField& field) {
  switch (field.source) {
    case FieldSource::position:
      return "P.";
    case FieldSource::bias:
      return "bias.";
    case FieldSource::normal:
      return "N.";
    case FieldSource::tangent:
      return "T.";
    case FieldSource::material:
      return std::string(field.name) + ".";
  }
  return "";
}

std::vector<std::string> components_of(const SampleField& field) {
  if (field.width == 1) return {"V"};
  if (field.source == FieldSource::material) return {"R", "G", "B"};
  return {"X", "Y", "Z"};
}

float id_of_shader(const ShaderInfo* shader) {
  const auto shaders = shader_table();
  return static_cast<float>(std::find(shaders.begin(), shaders.end(), shader) - shaders.begin() +
                            1);
}

}  // namespace relume

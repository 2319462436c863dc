#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include "core/base/label.h"
#include "core/math/vec.h"

namespace relume {

/// How reduction may combine a field of merged samples (TR2007-600 sec. 2.1): the weighted mean of
/// all members, or the value of the one sample that represents the cluster.
enum class Merge { average, representative };

inline constexpr std::array merge_labels = {
    Label<Merge>{Merge::average, "average"},
    Label<Merge>{Merge::representative, "representative"},
};

/// What a field is to the response, for methods that know more than the report's (Light-Fit) and
/// for feature scaling.
enum class FieldKind {
  anchor,     ///< a position: always a real sample's
  direction,  ///< a unit vector
  axis,       ///< a unit vector whose sign does not matter (a strand's tangent)
  scalar,     ///< a number within `low..high`
  linear,     ///< the response is proportional to it (a colour)
};

/// Where the sampler takes a field from.
enum class FieldSource {
  position,  ///< world space
  bias,      ///< shadow-ray bias in world units, see core/trace/ray_bias.h
  normal,    ///< shading normal, world space, flipped to face the eye
  tangent,   ///< strand direction, world space
  material,  ///< the material, see material_parameters
};

/// One field of a sample vector.
struct SampleField {
  std::string_view name;
  int width;  ///< floats: 1 or 3
  FieldKind kind;
  FieldSource source;
  std::string_view unit;
  Merge merge;        ///< default; a material may override it
  float low = 0;      ///< smallest value a material may give (kind linear and scalar)
  float high = 0;     ///< largest
  float initial = 0;  ///< value, in every component, when the material says nothing
};

/// A shader as data: its name in scene files and the fields of its samples, in order. Constants of
/// this type are declared by the shader files in core/shade; scene and samples only read them.
struct ShaderInfo {
  std::string_view name;
  std::span<const SampleField> fields;
  bool two_sided_transmission = false;  ///< lit from behind too
  /// Where materials give something else than their fields' values: what they give, and how the
  /// fields of FieldSource::material, in their order, follow from its values.
  std::span<const SampleField> parameters = {};
  void (*fields_of_parameters)(const vec3* parameters, vec3* fields) = nullptr;
};

/// What a material of `shader` may give, by name: a constant, times a texture where one is named.
inline std::vector<SampleField> material_parameters(const ShaderInfo& shader) {
  if (!shader.parameters.empty()) return {shader.parameters.begin(), shader.parameters.end()};
  std::vector<SampleField> parameters;
  for (const SampleField& field : shader.fields) {
    if (field.source == FieldSource::material) parameters.push_back(field);
  }
  return parameters;
}

/// The scalar factors of a shader's response that its colours multiply: response = sum over k of
/// color[k] * value[k].
template <class F, int N>
struct Lobes {
  F value[N];
};

/// The fields every sample starts with, whatever its shader: indices into ShaderInfo::fields.
inline constexpr int position_field = 0;
inline constexpr int bias_field = 1;

inline constexpr SampleField position_field_info{
    "position", 3, FieldKind::anchor, FieldSource::position, "world", Merge::representative};
inline constexpr SampleField bias_field_info{
    "bias", 1, FieldKind::scalar, FieldSource::bias, "world", Merge::representative};

}  // namespace relume

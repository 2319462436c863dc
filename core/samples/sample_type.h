#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace relume {

inline constexpr int max_sample_types = 64;  ///< of a scene

/// A sample type: one shader's fields with the merge categories that an artist chose. Samples of
/// different types are never merged, even when their widths agree (TR2007-600 sec. 2.1).
struct SampleType {
  std::string name;  ///< the shader's name, with "#2", "#3" for other merge choices
  const ShaderInfo* shader = nullptr;
  std::vector<Merge> merges;  ///< per field
  std::vector<int> offsets;   ///< per field: first float within a sample vector
  int width = 0;              ///< floats per sample vector

  size_t field_count() const { return merges.size(); }
  const SampleField& field(size_t i) const { return shader->fields[i]; }
};

/// The types that a scene's materials need, in order of first use, and each material's type.
/// make_sample_types throws Error(limit) above max_sample_types.
struct SampleTypes {
  std::vector<SampleType> types;
  std::vector<uint16_t> type_of_material;
};

/// First float, within a sample vector, of the type's first field of this source; -1 = has none.
int field_offset(const SampleType& type, FieldSource source);

SampleType make_sample_type(const ShaderInfo& shader);
SampleTypes make_sample_types(const Scene& scene);

}  // namespace relume

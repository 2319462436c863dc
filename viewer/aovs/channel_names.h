#pragma once

#include <string>
#include <vector>

#include "core/samples/sample_type.h"

namespace relume {

/// The layer that a field stands in where this program writes samples: "P.", "N.", "diffuse." ...;
/// the preset "relume" reads them.
std::string layer_of(const SampleField& field);

/// Names of the field's components within its layer.
std::vector<std::string> components_of(const SampleField& field);

/// The number that marks a shader's samples in the channel "id", >= 1.
float id_of_shader(const ShaderInfo* shader);

}  // namespace relume

#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// Where one field of a sample vector comes from: a layer or channel of an image, or a constant.
struct ChannelSource {
  std::string field;  ///< of the shader, or "roughness" for an exponent
  std::string layer;  ///< empty: `constant`
  vec3 constant{0};
};

/// The samples of one shader in an image.
struct ChannelType {
  const ShaderInfo* shader = nullptr;
  std::optional<float> id;  ///< value of ChannelMap::id that marks them; nothing: all samples
  std::vector<ChannelSource> fields;
};

/// Which channels of an AOV image hold what (docs/aov-input.md). A layer "P" stands for channels
/// P.X, P.Y, P.Z, or R, G, B, or x, y, z, or r, g, b; a single channel for itself or its only
/// component. Names may leave out leading layers: "P" finds "ViewLayer.P.X".
struct ChannelMap {
  std::string coverage;  ///< > 0.5 where a sample hit; empty: where the normal or tangent is not 0
  std::string id;        ///< empty: there is one type
  std::vector<ChannelType> types;
};

/// Names of the presets: "cycles", "arnold", "renderman", "relume".
std::vector<std::string> channel_preset_names();

/// A preset by its name, or the map in a JSON file. Throws Error(input) naming file and field.
ChannelMap load_channel_map(const std::string& preset_or_path,
                            std::span<const ShaderInfo* const> shaders);

}  // namespace relume

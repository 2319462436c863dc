#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "core/scene/io/json_node.h"
#include "core/scene/scene.h"

namespace relume {

/// The materials that a scene file names itself (those of OBJ files are not among them).
class MaterialNames {
 public:
  void add(const std::string& name, uint32_t index) { indices_.emplace(name, index); }
  bool has(const std::string& name) const { return indices_.contains(name); }
  /// The material that the string `node` names.
  uint32_t find(const JsonNode& node) const;

 private:
  std::map<std::string, uint32_t> indices_;
};

/// The path that the string `node` names, relative to `folder` unless absolute.
std::filesystem::path read_path(const JsonNode& node, const std::filesystem::path& folder);

/// Reads a list of materials into scene.materials. Textures are loaded, parameters are checked
/// against the fields of the shaders in scene.shaders.
MaterialNames read_materials(const JsonNode& list, const std::filesystem::path& folder,
                             Scene& scene);

}  // namespace relume

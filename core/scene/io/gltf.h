#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/io/imported_material.h"

namespace relume {

/// True for the extensions .gltf and .glb.
bool is_gltf_path(const std::filesystem::path& path);

/// Reads a .gltf or .glb (read_gltf) and adds its materials, textures and one prototype a mesh to
/// `scene`; returns where its default scene places them, as instances of those prototypes.
/// Metallic-roughness materials become our ggx, with their textures and normal maps. Blended alpha
/// is cut out at one half. Throws as read_gltf.
std::vector<Instance> load_gltf(const std::filesystem::path& path, const MaterialOptions& options,
                                Scene& scene);

/// A scene file's text (docs/scene-format.md) that shows a glTF: its first camera, else one that
/// sees it all; its lights, else three of our own.
std::string gltf_scene_text(const std::filesystem::path& path);

}  // namespace relume

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace relume {

/// True for the extensions .gltf and .glb.
bool is_gltf_path(const std::filesystem::path& path);

/// How a glTF's materials become ours.
struct GltfOptions {
  int phong_shader = -1;  ///< index into Scene::shaders; -1: not there
  int leaf_shader = -1;
  std::vector<std::string> leaf_materials;  ///< names that become two-sided translucent leaves
  float leaf_transmission = 0.5f;           ///< transmit = this times the diffuse colour
  int material_override = -1;               ///< index into Scene::materials used for all, or -1
};

/// Reads a .gltf or .glb (read_gltf) and adds its materials, textures and one prototype a mesh to
/// `scene`; returns where its default scene places them, as instances of those prototypes.
/// Metallic-roughness materials become our Phong: diffuse = base (1 - metallic), specular =
/// lerp(0.04, base, metallic), exponent = 2 / (4 roughness^4) from the width of the GGX lobe about
/// the mirror direction; of a metallic-roughness texture the mean counts. Blended alpha is cut out
/// at one half. Throws as read_gltf.
std::vector<Instance> load_gltf(const std::filesystem::path& path, const GltfOptions& options,
                                Scene& scene);

/// A scene file's text (docs/scene-format.md) that shows a glTF: its first camera, else one that
/// sees it all; its lights, else three of our own.
std::string gltf_scene_text(const std::filesystem::path& path);

}  // namespace relume

#pragma once

#include <filesystem>

#include "core/scene/scene.h"

namespace relume {

struct ObjOptions {
  /// Faces that meet at less than this angle share a smooth normal where the file has none.
  float smooth_angle_deg = 40;
  /// Shader of materials without highlight / with highlight / of materials listed as leaves.
  int lambert_shader = -1;
  int phong_shader = -1;
  int leaf_shader = -1;
  std::vector<std::string> leaf_materials;  ///< MTL names that become two-sided translucent leaves
  float leaf_transmission = 0.5f;           ///< transmit = this times the diffuse colour
  int material_override = -1;               ///< index into Scene::materials used for all, or -1
};

/// Reads an OBJ with its MTL and textures and adds what it needs to `scene`: returns the shapes,
/// whose material indices refer to scene.materials. Polygons are triangulated, zero-area triangles
/// dropped (counted in the rare events), missing normals computed, map_d becomes an alpha cut-out,
/// lines and points ignored. Classic Phong coefficients (Ks, Ns) become our normalised lobe of
/// equal peak-to-diffuse ratio. Throws Error(input) naming file and line, or Error(limit).
Mesh load_obj(const std::filesystem::path& path, const ObjOptions& options, Scene& scene);

}  // namespace relume

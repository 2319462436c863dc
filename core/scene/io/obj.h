#pragma once

#include <filesystem>

#include "core/scene/io/imported_material.h"

namespace relume {

struct ObjOptions : MaterialOptions {
  /// Faces that meet at less than this angle share a smooth normal where the file has none.
  float smooth_angle_deg = 40;
};

/// Reads an OBJ with its MTL and textures and adds what it needs to `scene`: returns the shapes,
/// whose material indices refer to scene.materials. Polygons are triangulated, zero-area triangles
/// dropped (counted in the rare events), missing normals computed, map_d becomes an alpha cut-out,
/// lines and points ignored. Classic Phong coefficients (Ks, Ns) become our normalised lobe of
/// equal peak-to-diffuse ratio. Throws Error(input) naming file and line, or Error(limit).
Mesh load_obj(const std::filesystem::path& path, const ObjOptions& options, Scene& scene);

}  // namespace relume

#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/vec.h"
#include "core/scene/io/obj.h"

namespace relume {

/// What the strict pass over an OBJ text found.
struct ObjSummary {
  uint64_t positions = 0;
  uint64_t uvs = 0;
  uint64_t normals = 0;
  uint64_t faces = 0;
  uint64_t corners = 0;                     ///< summed over faces
  std::vector<std::string> material_files;  ///< the rest of each mtllib line
};

/// Checks every line of an OBJ before the lenient parser sees it: statements, numbers (finite,
/// within max_coordinate), indices (not 0, within the file's counts), faces of at least three
/// corners. Throws Error(input) as "FILE:LINE: what; mend", also when the text seems cut short: it
/// has no faces, or its last line is geometry without a line end while some vertices are used by no
/// face.
ObjSummary check_obj_text(std::string_view text, const std::string& file);

/// The same for an MTL text: numbers of the statements that are read later, names that are missing.
void check_mtl_text(std::string_view text, const std::string& file);

/// A corner of a face: indices from 0, or -1 where the file gives none.
struct ObjCorner {
  int32_t position = -1;
  int32_t uv = -1;
  int32_t normal = -1;
};

/// An OBJ file as it stands, indices resolved.
struct ObjContent {
  std::vector<vec3> positions;
  std::vector<vec2> uvs;
  std::vector<vec3> normals;
  std::vector<ObjCorner> corners;
  std::vector<uint64_t> face_offsets{0};        ///< face i owns corners [offset i, offset i + 1)
  std::vector<uint32_t> face_materials;         ///< index into material_names
  std::vector<std::string> material_names{""};  ///< in order of use; "" where no usemtl came before
};

/// One material of an MTL file, with what is used of it.
struct MtlMaterial {
  std::string file;  ///< the MTL file, for messages and relative textures
  vec3 diffuse{0.5f};
  vec3 specular{0};
  vec3 emission{0};
  float exponent = 0;
  float opacity = 1;
  std::string diffuse_texture;  ///< as written, or empty
  std::string alpha_texture;
  std::string emission_texture;
};

/// Materials by name; those of the first file win.
using MtlTable = std::map<std::string, MtlMaterial>;

/// Marks faces whose material is see-through as a whole (d < 0.5): they are left out.
inline constexpr uint32_t hidden_material = UINT32_MAX;

/// Adds the materials that `content` uses to `scene`. Returns, for each of content.material_names,
/// the index into scene.materials or hidden_material.
std::vector<uint32_t> add_obj_materials(const ObjContent& content, const MtlTable& table,
                                        const std::filesystem::path& obj_file,
                                        const ObjOptions& options, Scene& scene);

/// The triangles of `content`: polygons cut, faces of hidden materials left out, triangles without
/// area dropped (counted), vertices split where texture coordinates or normals differ. `materials`
/// is per material name, as add_obj_materials returns it. `file` stands in messages.
Mesh build_obj_mesh(const ObjContent& content, const std::vector<uint32_t>& materials,
                    float smooth_angle_deg, const std::string& file);

}  // namespace relume

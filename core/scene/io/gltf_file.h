#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/math/transform.h"
#include "core/scene/camera.h"
#include "core/scene/light.h"

namespace relume {

/// A PNG or JPEG file inside a glTF, not decoded.
struct GltfImage {
  std::string name;
  std::vector<std::byte> bytes;
};

enum class GltfAlpha { opaque, mask, blend };

/// A metallic-roughness material as glTF 2.0 sec. 3.9 has it; images by index, -1: none.
struct GltfMaterial {
  std::string name;
  vec4 base_color{1};
  int base_image = -1;  ///< sRGB; its alpha channel counts unless opaque
  float metallic = 1;
  float roughness = 1;
  int metal_rough_image = -1;  ///< linear: green roughness, blue metallic
  float reflectance = 0.04f;   ///< F0 where it is no metal (KHR_materials_ior, _specular)
  int normal_image = -1;       ///< linear, tangent space
  float normal_scale = 1;
  vec3 emission{0};         ///< radiance, times the strength of KHR_materials_emissive_strength
  int emission_image = -1;  ///< sRGB
  GltfAlpha alpha = GltfAlpha::opaque;
  float alpha_cutoff = 0.5f;
  std::vector<std::string> left_out;  ///< what it says and we lack, in words
};

/// Triangles under one material. Arrays as in Mesh: normals and uvs are empty or parallel to
/// positions; uvs are those of the first texture of base colour, metallic-roughness, normals and
/// emission, v upwards.
struct GltfPrimitive {
  std::vector<vec3> positions;
  std::vector<vec3> normals;  ///< as they stand, of any length
  std::vector<vec2> uvs;
  std::vector<vec4> tangents;  ///< empty unless the file has them and the material a normal map
  std::vector<uvec3> triangles;
  int material = -1;  ///< -1: the default one
};

struct GltfMesh {
  std::string name;
  std::vector<GltfPrimitive> primitives;
};

/// A mesh at a node of the scene.
struct GltfPlacement {
  int mesh = 0;
  mat4x3 world_from_local = identity_transform();
};

struct GltfCamera {
  Camera camera;
  float aspect = 0;  ///< width / height; 0: any
};

/// What we take from a glTF: its default scene, at rest. Indices are checked, values finite.
struct GltfContent {
  std::vector<GltfImage> images;
  std::vector<GltfMaterial> materials;
  std::vector<GltfMesh> meshes;
  std::vector<GltfPlacement> placements;
  std::vector<GltfCamera> cameras;  ///< perspective ones
  std::vector<Light> lights;        ///< KHR_lights_punctual; unique names without dots
};

/// Reads a .gltf or .glb with its buffers and images (Khronos, glTF 2.0). Extensions that the file
/// requires and we lack are refused by name before anything is decoded. Left out: skins, morph
/// targets, animation, vertex colours, occlusion, orthographic cameras; lines and points.
/// Throws Error(input) or Error(limit) that names the file and the place in it.
GltfContent read_gltf(const std::filesystem::path& path);

}  // namespace relume

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/math/transform.h"
#include "core/math/vec.h"
#include "core/scene/camera.h"
#include "core/scene/light.h"
#include "core/scene/shader_info.h"

namespace relume {

/// An 8-bit texture, decoded. Rows run top to bottom; v = 0 is the bottom row (OBJ convention).
struct Texture {
  std::string name;
  int width = 0;
  int height = 0;
  bool srgb = true;             ///< decode with the sRGB curve; false for alpha and data
  std::vector<uint8_t> texels;  ///< width * height * 4, RGBA
};

/// The value of one material parameter: a constant, times a texture where one is named.
struct MaterialParameter {
  std::string name;  ///< one of material_parameters(shader)
  vec3 value{0};     ///< for width 1 only x counts
  int texture = -1;  ///< index into Scene::textures, or -1
  int channel = 0;   ///< of the texture, for width 1: 0 to 3 for red, green, blue, alpha
};

/// A surface or strand material: a shader's name and its parameters.
struct Material {
  std::string name;
  int shader = 0;  ///< index into Scene::shaders
  std::vector<MaterialParameter>
      parameters;  ///< those that differ from the shader's initial values
  int alpha_texture =
      -1;  ///< cut-out mask: where its alpha (or luminance) is < alpha_cutoff, no hit
  bool alpha_from_luminance = false;  ///< mask is a grey image (MTL map_d), not an alpha channel
  float alpha_cutoff = 0.5f;
  /// Tangent-space normals of surfaces as glTF 2.0 sec. 3.9.3 has them (x along u, y along v
  /// upwards), or -1. Their x and y are times normal_scale.
  int normal_texture = -1;
  float normal_scale = 1;
  /// The artist's choice, TR2007-600 sec. 2.1: fields (by name) whose merge category differs from
  /// the shader's default.
  std::vector<std::pair<std::string, Merge>> merges;
  /// Radiance that it sends out on all sides by itself, linear RGB, >= 0, whatever the lights do.
  /// It is seen; it lights nothing else.
  vec3 emission{0};
  int emission_texture = -1;  ///< sRGB, multiplies it; index into Scene::textures, or -1
};

/// Triangles. Invariants after load: indices < positions.size(); normals, uvs and
/// tangents are empty or parallel to positions; every value finite; no zero-area triangle.
struct Mesh {
  std::vector<vec3> positions;
  std::vector<vec3> normals;  ///< unit, shading
  std::vector<vec2> uvs;
  std::vector<uvec3> triangles;
  std::vector<uint32_t> materials;  ///< per triangle, index into Scene::materials
  /// For normal maps: unit tangents along u and, in w, the sign of the bitangent
  /// cross(normal, tangent) along v. Empty: each triangle's own, from its uvs.
  std::vector<vec4> tangents{};
};

/// Strands of linear segments. Invariants after load: offsets has strands + 1 ascending entries;
/// every strand has >= 2 points, no zero-length segment; radii > 0 and finite.
struct Curves {
  std::vector<vec4> points;         ///< xyz world units of the shape, w = radius
  std::vector<uint32_t> offsets;    ///< strand i owns points [offsets[i], offsets[i+1])
  std::vector<uint32_t> materials;  ///< per strand, index into Scene::materials
  std::vector<vec3> colors;         ///< empty, or per strand: multiplies the "diffuse" parameter
};

/// A named thing that can be placed: several meshes and strands in one local space.
struct Prototype {
  std::string name;
  std::vector<std::variant<Mesh, Curves>> shapes;
};

struct Instance {
  uint32_t prototype = 0;
  mat4x3 world_from_local = identity_transform();
};

/// How instanced prototypes reach the ray tracer: one flat acceleration structure (3x faster rays,
/// memory of every copy) or two levels (memory of one). `automatic` flattens below a memory budget.
enum class Instancing { automatic, flatten, instance };

inline constexpr std::array instancing_labels = {
    Label<Instancing>{Instancing::automatic, "auto"},
    Label<Instancing>{Instancing::flatten, "flatten"},
    Label<Instancing>{Instancing::instance, "instance"},
};

/// Everything a scene file says, with files read and generators run. Immutable once loaded.
struct Scene {
  std::string name;
  int width = 512;   ///< pixels, [1, 16384]
  int height = 512;  ///< pixels, [1, 16384]
  Camera camera;
  std::vector<const ShaderInfo*> shaders;  ///< the table the loader was given
  std::vector<Texture> textures;
  std::vector<Material> materials;
  std::vector<Prototype> prototypes;
  std::vector<Instance> instances;
  std::vector<Light> lights;
  /// The two lights that bound the random training and test lights (TR2007-600 sec. 3.2).
  Light representative_low;
  Light representative_high;
  Instancing instancing = Instancing::automatic;
  float exposure = 0;  ///< display exposure in stops; does not touch any stored value

  std::filesystem::path file;  ///< where it was read from; empty for built-in scenes
  std::string text;            ///< the scene file's own text: enough, with `file`, to load it again
};

/// True when a material sends out light by itself.
bool has_emission(const Scene& scene);

/// Its materials send out nothing any more.
void remove_emission(Scene& scene);

/// Bounds of a prototype in its local space, strand radii included.
Bounds local_bounds(const Prototype& prototype);

/// Bounds of `local`'s eight corners, transformed; empty stays empty.
Bounds transform_bounds(const Bounds& local, const mat4x3& world_from_local);

/// Bounds of all instances in world space (from prototypes' corner points).
Bounds world_bounds(const Scene& scene);

struct SceneCounts {
  uint64_t triangles = 0;  ///< stored once per prototype
  uint64_t strands = 0;
  uint64_t segments = 0;
  uint64_t instanced_triangles = 0;  ///< as seen by rays
  uint64_t instanced_segments = 0;
};
SceneCounts count_scene(const Scene& scene);

/// Throws Error(input) or Error(limit), naming the field, when `scene` breaks an invariant above
/// that a loader or generator could break. Loaders call it last; so may tests that build scenes by
/// hand.
void validate_scene(const Scene& scene);

}  // namespace relume

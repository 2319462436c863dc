#include "core/scene/io/gltf.h"

#include <fmt/format.h>

#include <cctype>
#include <map>
#include <set>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/math/color.h"
#include "core/scene/io/alpha_mask.h"
#include "core/scene/io/gltf_file.h"
#include "core/scene/io/json_node.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/io/smooth_normals.h"
#include "core/scene/io/texture_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

RareEvent replaced_normals("glTF normals of zero length replaced");
RareEvent blended_materials("glTF materials of blended alpha cut out at one half");

constexpr float dielectric_specular = 0.04f;  ///< glTF 2.0, appendix B
constexpr float max_exponent = 1e5f;

/// Mean of a channel of a texture, [0, 1].
float mean_of(const Texture& texture, size_t channel) {
  uint64_t sum = 0;
  for (size_t i = channel; i < texture.texels.size(); i += 4) sum += texture.texels[i];
  const double texels = std::max<double>(1, static_cast<double>(texture.texels.size()) / 4);
  return static_cast<float>(static_cast<double>(sum) / (255 * texels));
}

/// Adds materials as they are asked for.
class MaterialMaker {
 public:
  MaterialMaker(const GltfContent& content, const std::string& file, const GltfOptions& options,
                Scene& scene)
      : content_(content), file_(file), options_(options), scene_(scene) {
    check_leaf_names();
  }

  /// The index in scene.materials of the glTF's material `index`, -1: its default one.
  uint32_t find(int index) {
    if (options_.material_override >= 0) return static_cast<uint32_t>(options_.material_override);
    const auto [found, is_new] = made_.try_emplace(index, 0);
    if (is_new) {
      if (scene_.materials.size() >= max_materials) {
        throw limit_error(file_, "too many materials",
                          fmt::format("the limit is {}", max_materials));
      }
      Material material = make(index < 0 ? GltfMaterial{} : content_.materials[index]);
      found->second = static_cast<uint32_t>(scene_.materials.size());
      scene_.materials.push_back(std::move(material));
    }
    return found->second;
  }

 private:
  void check_leaf_names() const {
    std::string known;
    std::set<std::string> names;
    for (const GltfMaterial& material : content_.materials) {
      if (names.insert(material.name).second) known += " \"" + material.name + "\"";
    }
    for (const std::string& leaf : options_.leaf_materials) {
      if (names.contains(leaf)) continue;
      throw input_error(file_, fmt::format("leaf material \"{}\" is not in it", leaf),
                        "the file has:" + known);
    }
  }

  int load(int image, bool srgb, const std::string& material) {
    if (image < 0) return -1;
    const GltfImage& source = content_.images[image];
    const std::string name = fmt::format("{}#{}", file_, image);
    return add_texture(
        scene_, source.bytes, name, srgb,
        fmt::format("{}: material \"{}\": image {} ({})", file_, material, image, source.name));
  }

  Material make(const GltfMaterial& source) {
    const auto& leaves = options_.leaf_materials;
    const bool leaf = std::ranges::find(leaves, source.name) != leaves.end();
    Material material;
    material.name = source.name.empty() ? "default" : source.name;
    material.shader = leaf ? options_.leaf_shader : options_.phong_shader;
    if (material.shader < 0) {
      throw input_error(file_, "the program lacks a shader for its materials",
                        "add phong and leaf to the shader table");
    }
    const int texture = load(source.base_image, true, source.name);
    const vec3 base(source.base_color);
    if (leaf) {
      material.parameters.push_back({"diffuse", base, texture});
      material.parameters.push_back({"transmit", base * options_.leaf_transmission, texture});
    } else {
      add_glossy(source, base, texture, material);
    }
    set_alpha(source, texture, material);
    return material;
  }

  void add_glossy(const GltfMaterial& source, vec3 base, int texture, Material& material) {
    float metallic = source.metallic;
    float roughness = source.roughness;
    if (const int image = load(source.metal_rough_image, false, source.name); image >= 0) {
      roughness *= mean_of(scene_.textures[image], 1);
      metallic *= mean_of(scene_.textures[image], 2);
    }
    material.parameters.push_back({"diffuse", base * (1 - metallic), texture});
    // Our specular has one texture: the base colour's where metal gives most of it.
    const bool is_metal = metallic > 0.5f;
    const vec3 specular =
        is_metal ? base * metallic : vec3(dielectric_specular) * (1 - metallic) + base * metallic;
    material.parameters.push_back({"specular", specular, is_metal ? texture : -1});
    // A GGX lobe of width alpha about the half vector is twice as wide about the mirror direction.
    const float alpha = std::max(roughness * roughness, 1e-3f);
    const float exponent = std::min(0.5f / (alpha * alpha), max_exponent);
    material.parameters.push_back({"exponent", vec3(exponent), -1});
  }

  void set_alpha(const GltfMaterial& source, int texture, Material& material) {
    if (source.alpha == GltfAlpha::opaque || texture < 0) return;
    if (!has_transparency(scene_.textures[texture])) return;
    if (source.alpha == GltfAlpha::blend) blended_materials.add();
    const float cutoff = source.alpha == GltfAlpha::blend ? 0.5f : source.alpha_cutoff;
    material.alpha_texture = texture;
    material.alpha_cutoff = std::min(1.0f, cutoff / std::max(source.base_color.w, 1e-3f));
  }

  const GltfContent& content_;
  const std::string& file_;
  const GltfOptions& options_;
  Scene& scene_;
  std::map<int, uint32_t> made_;
};

/// Faces without normals are flat, as glTF asks.
void make_flat(const GltfPrimitive& source, Mesh& mesh) {
  const SmoothNormals flat = make_smooth_normals(source.positions, source.triangles, 0);
  for (size_t t = 0; t < source.triangles.size(); ++t) {
    uvec3 corners;
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t vertex = source.triangles[t][c];
      corners[c] = static_cast<uint32_t>(mesh.positions.size());
      mesh.positions.push_back(source.positions[vertex]);
      mesh.normals.push_back(flat.normals[flat.normal_of_corner[3 * t + c]]);
      if (!source.uvs.empty()) mesh.uvs.push_back(source.uvs[vertex]);
    }
    mesh.triangles.push_back(corners);
  }
}

/// The mean of the faces at each vertex, for those whose normal says nothing.
void mend_normals(Mesh& mesh) {
  std::vector<dvec3> sums;
  for (size_t v = 0; v < mesh.normals.size(); ++v) {
    mesh.normals[v] = normalize_or(mesh.normals[v], vec3(0));
    if (mesh.normals[v] != vec3(0)) continue;
    replaced_normals.add();
    if (sums.empty()) {
      sums.assign(mesh.positions.size(), dvec3(0));
      for (const uvec3 t : mesh.triangles) {
        const dvec3 a(mesh.positions[t.x]);
        const dvec3 normal =
            glm::cross(dvec3(mesh.positions[t.y]) - a, dvec3(mesh.positions[t.z]) - a);
        for (size_t c = 0; c < 3; ++c) sums[t[c]] += normal;
      }
    }
    const double length = glm::length(sums[v]);
    mesh.normals[v] = length > 0 ? vec3(sums[v] / length) : vec3(0, 1, 0);
  }
}

Mesh make_mesh(const GltfPrimitive& source, uint32_t material) {
  Mesh mesh;
  if (source.normals.empty()) {
    make_flat(source, mesh);
  } else {
    mesh.positions = source.positions;
    mesh.normals = source.normals;
    mesh.uvs = source.uvs;
    mesh.triangles = source.triangles;
    mend_normals(mesh);
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

std::string format_vector(vec3 v) {
  return fmt::format("[{}, {}, {}]", json_number(v.x), json_number(v.y), json_number(v.z));
}

}  // namespace

bool is_gltf_path(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return std::tolower(c); });
  return extension == ".gltf" || extension == ".glb";
}

std::vector<Instance> load_gltf(const std::filesystem::path& path, const GltfOptions& options,
                                Scene& scene) {
  const std::string file = path.string();
  const GltfContent content = read_gltf(path);
  if (content.placements.empty()) {
    throw input_error(file, "its default scene shows no triangle", "check its nodes and meshes");
  }
  MaterialMaker materials(content, file, options, scene);
  std::map<int, uint32_t> prototypes;
  std::vector<Instance> instances;
  for (const GltfPlacement& placement : content.placements) {
    const auto next = static_cast<uint32_t>(scene.prototypes.size());
    const auto [found, is_new] = prototypes.try_emplace(placement.mesh, next);
    if (is_new) {
      const GltfMesh& mesh = content.meshes[placement.mesh];
      Prototype& prototype = scene.prototypes.emplace_back();
      prototype.name = mesh.name;
      for (const GltfPrimitive& primitive : mesh.primitives) {
        prototype.shapes.emplace_back(make_mesh(primitive, materials.find(primitive.material)));
      }
    }
    instances.push_back({found->second, placement.world_from_local});
  }
  return instances;
}

std::string gltf_scene_text(const std::filesystem::path& path) {
  const GltfContent content = read_gltf(path);
  constexpr int height = 512;
  int width = height;
  std::string camera =
      R"({"fit": true, "direction": [-0.5, -0.35, -0.8], "fov_y_deg": 35, "margin": 1.1})";
  if (!content.cameras.empty()) {
    const GltfCamera& source = content.cameras.front();
    if (source.aspect > 0) {
      width = std::clamp(static_cast<int>(std::lround(height * source.aspect)), 1, max_image_side);
    }
    camera = fmt::format(R"({{"eye": {}, "target": {}, "up": {}, "fov_y_deg": {}}})",
                         format_vector(source.camera.eye), format_vector(source.camera.target),
                         format_vector(source.camera.up), json_number(source.camera.fov_y_deg));
  }
  std::string lights = R"([
    {"name": "key", "position": {"relative": [2, 2.5, 1.5]}, "gain_relative": 40},
    {"name": "fill", "position": {"relative": [-2.5, 1, 2.5]}, "gain_relative": 10},
    {"name": "rim", "position": {"relative": [-2.5, 1.5, -2]}, "gain_relative": 20}
  ])";
  if (!content.lights.empty()) {
    const std::string list = format_lights(content.lights);
    const size_t first = list.find('[');
    lights = list.substr(first, list.rfind(']') + 1 - first);
  }
  return fmt::format(
      "{{\n  \"name\": {},\n  \"image\": {{\"width\": {}, \"height\": {}}},\n  \"camera\": {},\n"
      "  \"geometry\": [{{\"file\": {}}}],\n  \"lights\": {}\n}}\n",
      json_quoted(printable(path.stem().string(), max_name_length)), width, height, camera,
      json_quoted(path.filename().string()), lights);
}

}  // namespace relume

#include "core/scene/io/gltf.h"

#include <fmt/format.h>

#include <cctype>
#include <map>
#include <set>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/scene/io/alpha_mask.h"
#include "core/scene/io/gltf_file.h"
#include "core/scene/io/imported_scene.h"
#include "core/scene/io/smooth_normals.h"
#include "core/scene/io/texture_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

RareEvent replaced_normals("glTF normals of zero length replaced");
RareEvent blended_materials("glTF materials of blended alpha cut out at one half");

/// Adds materials as they are asked for.
class MaterialMaker {
 public:
  MaterialMaker(const GltfContent& content, const std::string& file, const MaterialOptions& options,
                Scene& scene)
      : content_(content), file_(file), options_(options), scene_(scene) {
    std::vector<std::string> names;
    for (const GltfMaterial& material : content.materials) names.push_back(material.name);
    check_leaf_materials(options, names, file);
  }

  /// The index in scene.materials of the glTF's material `index`, -1: its default one.
  uint32_t find(int index) {
    if (options_.material_override >= 0) return static_cast<uint32_t>(options_.material_override);
    const auto [found, is_new] = made_.try_emplace(index, 0);
    if (is_new) {
      Material material = make(index < 0 ? GltfMaterial{} : content_.materials[index]);
      found->second = add_material(scene_, std::move(material), file_);
    }
    return found->second;
  }

  /// Tells what of the materials in use is left out.
  void print_note() const {
    if (left_out_.empty()) return;
    std::string list;
    for (const std::string& part : left_out_) list += (list.empty() ? "" : ", ") + part;
    print_import_note(file_, "its materials are read without " + list);
  }

 private:
  int load(int image, bool srgb, const std::string& material) {
    if (image < 0) return -1;
    const GltfImage& source = content_.images[image];
    const std::string name = fmt::format("{}#{}", file_, image);
    return add_texture(
        scene_, source.bytes, name, srgb,
        fmt::format("{}: material \"{}\": image {} ({})", file_, material, image, source.name));
  }

  Material make(const GltfMaterial& source) {
    Material material;
    material.name = source.name.empty() ? "default" : source.name;
    const int texture = load(source.base_image, true, source.name);
    const vec3 base(source.base_color);
    if (is_leaf(options_, source.name)) {
      make_leaf(scene_, options_, base, texture, file_, material);
    } else {
      material.shader = find_shader(scene_, "ggx", file_);
      const int surface = load(source.metal_rough_image, false, source.name);
      material.parameters = {{"base_color", base, texture},
                             {"metallic", vec3(source.metallic), surface, 2},
                             {"reflectance", vec3(source.reflectance)},
                             {"roughness", vec3(source.roughness), surface, 1}};
    }
    material.normal_texture = load(source.normal_image, false, source.name);
    material.normal_scale = source.normal_scale;
    material.emission = source.emission;
    material.emission_texture = load(source.emission_image, true, source.name);
    set_alpha(source, texture, material);
    left_out_.insert(source.left_out.begin(), source.left_out.end());
    return material;
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
  const MaterialOptions& options_;
  Scene& scene_;
  std::map<int, uint32_t> made_;
  std::set<std::string> left_out_;
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
    mesh.tangents = source.tangents;
    mesh.triangles = source.triangles;
    mend_normals(mesh);
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

}  // namespace

bool is_gltf_path(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return std::tolower(c); });
  return extension == ".gltf" || extension == ".glb";
}

std::vector<Instance> load_gltf(const std::filesystem::path& path, const MaterialOptions& options,
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
  materials.print_note();
  return instances;
}

std::string gltf_scene_text(const std::filesystem::path& path) {
  GltfContent content = read_gltf(path);
  ImportedView view;
  view.lights = std::move(content.lights);
  if (!content.cameras.empty()) {
    const GltfCamera& source = content.cameras.front();
    view.camera = source.camera;
    if (source.aspect > 0) {
      const auto width =
          static_cast<int>(std::lround(static_cast<float>(view.height) * source.aspect));
      view.width = std::clamp(width, 1, max_image_side);
    }
  }
  return imported_scene_text(path, view);
}

}  // namespace relume

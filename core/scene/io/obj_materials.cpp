#include <fmt/format.h>

#include <set>

#include "core/math/color.h"
#include "core/scene/io/alpha_mask.h"
#include "core/scene/io/obj_parts.h"
#include "core/scene/io/texture_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr float max_exponent = 1e5f;

/// The image that an MTL statement names: backslashes become slashes; a path that does not exist
/// (one of the artist's own machine) is looked up by its last part beside the MTL file.
std::filesystem::path texture_path(const std::string& mtl_file, std::string name) {
  std::replace(name.begin(), name.end(), '\\', '/');
  const std::filesystem::path folder = std::filesystem::path(mtl_file).parent_path();
  const std::filesystem::path path = folder / name;
  const std::filesystem::path beside = folder / std::filesystem::path(name).filename();
  std::error_code ignored;
  const bool moved =
      !std::filesystem::exists(path, ignored) && std::filesystem::exists(beside, ignored);
  return moved ? beside : path;
}

class MaterialMaker {
 public:
  MaterialMaker(const std::string& name, const MtlMaterial& source, const ObjOptions& options,
                Scene& scene)
      : name_(name), source_(source), options_(options), scene_(scene) {}

  Material make(bool leaf) {
    const vec3 diffuse = glm::clamp(source_.diffuse, vec3(0), vec3(1));
    const vec3 specular = glm::clamp(source_.specular, vec3(0), vec3(1));
    const float exponent = std::clamp(source_.exponent, 0.0f, max_exponent);
    const bool glossy = luminance(specular) > 0 && source_.exponent > 0;
    material_.name = name_.empty() ? "default" : name_;
    int texture = -1;
    if (!source_.diffuse_texture.empty()) {
      texture = load(source_.diffuse_texture, true, "map_Kd");
    }
    if (leaf) {
      make_leaf(scene_, options_, diffuse, texture, source_.file, material_);
    } else {
      material_.shader = find_shader(scene_, glossy ? "phong" : "lambert", source_.file);
      material_.parameters.push_back({"diffuse", diffuse, texture});
    }
    if (glossy && !leaf) {
      // Classic Phong adds kd (n.l) and ks (r.v)^Ns; ours divides kd by pi and scales the lobe by
      // (Ns + 2) / (2 pi). The ratio of the lobe's peak to the diffuse part stays ks / kd with:
      const vec3 normalised = specular * (2.0f / (exponent + 2.0f));
      material_.parameters.push_back({"specular", normalised, -1});
      material_.parameters.push_back({"exponent", vec3(exponent), -1});
    }
    read_emission();
    read_alpha(texture);
    return material_;
  }

 private:
  int load(const std::string& name, bool srgb, std::string_view statement) {
    const std::string place =
        fmt::format("{}: material \"{}\": {}", source_.file, name_, statement);
    return add_texture(scene_, texture_path(source_.file, name), srgb, place);
  }

  /// Ke, times map_Ke.
  void read_emission() {
    material_.emission = glm::clamp(source_.emission, vec3(0), vec3(max_emission));
    if (max_component(material_.emission) > 0 && !source_.emission_texture.empty()) {
      material_.emission_texture = load(source_.emission_texture, true, "map_Ke");
    }
  }

  /// map_d, or the alpha channel of map_Kd where that cuts anything out.
  void read_alpha(int diffuse_texture) {
    if (source_.alpha_texture.empty()) {
      if (diffuse_texture >= 0 && has_transparency(scene_.textures[diffuse_texture])) {
        set_alpha_mask(scene_, diffuse_texture, material_);
      }
      return;
    }
    const bool same = source_.alpha_texture == source_.diffuse_texture;
    set_alpha_mask(scene_, same ? diffuse_texture : load(source_.alpha_texture, false, "map_d"),
                   material_);
    // One image for both and opaque: its colours are no mask.
    if (same && material_.alpha_from_luminance) material_.alpha_texture = -1;
  }

  const std::string& name_;
  const MtlMaterial& source_;
  const ObjOptions& options_;
  Scene& scene_;
  Material material_;
};

}  // namespace

std::vector<uint32_t> add_obj_materials(const ObjContent& content, const MtlTable& table,
                                        const std::filesystem::path& obj_file,
                                        const ObjOptions& options, Scene& scene) {
  const std::string file = obj_file.string();
  check_leaf_materials(options, content.material_names, file);
  const std::set<uint32_t> used(content.face_materials.begin(), content.face_materials.end());
  std::vector<uint32_t> indices(content.material_names.size(), hidden_material);
  std::string missing;
  for (const uint32_t i : used) {
    const std::string& name = content.material_names[i];
    MtlMaterial source;
    source.file = file;
    if (const auto found = table.find(name); found != table.end()) {
      source = found->second;
    } else if (!name.empty()) {
      missing += fmt::format("{}\"{}\"", missing.empty() ? "" : ", ", name);
    }
    if (source.opacity < 0.5f) continue;
    Material material = MaterialMaker(name, source, options, scene).make(is_leaf(options, name));
    indices[i] = add_material(scene, std::move(material), file);
  }
  if (!missing.empty()) {
    print_import_note(file, fmt::format("no MTL file defines {}; grey is used", missing));
  }
  return indices;
}

}  // namespace relume

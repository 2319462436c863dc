#include "core/scene/io/json_materials.h"

#include <fmt/format.h>

#include "core/scene/io/alpha_mask.h"
#include "core/scene/io/texture_file.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

/// Reads one material of a scene file.
class MaterialReader {
 public:
  MaterialReader(const JsonNode& node, const std::filesystem::path& folder, Scene& scene)
      : node_(node), folder_(folder), scene_(scene) {}

  Material read() {
    if (!node_.is_object()) throw node_.error("is not an object", "give { ... }");
    material_.name = node_.get("name", "give each material a \"name\"").text(max_name_length);
    read_shader();
    expect_known_keys();
    for (const SampleField& field : material_parameters(shader())) {
      if (const auto value = node_.find(field.name)) read_parameter(*value, field);
    }
    if (const auto alpha = node_.find("alpha")) read_alpha(*alpha);
    if (const auto map = node_.find("normal_map")) read_normal_map(*map);
    if (const auto emission = node_.find("emission")) read_emission(*emission);
    if (const auto merge = node_.find("merge")) read_merges(*merge);
    return material_;
  }

 private:
  const ShaderInfo& shader() const { return *scene_.shaders[material_.shader]; }

  void read_shader() {
    const JsonNode node = node_.get("shader", "name one: " + shader_names());
    const std::string name = node.text(max_name_length);
    for (size_t i = 0; i < scene_.shaders.size(); ++i) {
      if (scene_.shaders[i]->name != name) continue;
      material_.shader = static_cast<int>(i);
      return;
    }
    throw node.error(fmt::format("\"{}\" is unknown", name), "give one of: " + shader_names());
  }

  std::string shader_names() const {
    std::string names;
    for (const ShaderInfo* info : scene_.shaders) {
      names += fmt::format("{}{}", names.empty() ? "" : ", ", info->name);
    }
    return names;
  }

  void expect_known_keys() const {
    std::vector<std::string_view> keys{"name", "shader", "alpha", "merge", "emission"};
    const auto is_normal = [](const SampleField& f) { return f.source == FieldSource::normal; };
    if (std::ranges::any_of(shader().fields, is_normal)) keys.emplace_back("normal_map");
    for (const SampleField& field : material_parameters(shader())) keys.push_back(field.name);
    node_.expect_keys(keys);
  }

  /// A constant: one number for every component, or three.
  vec3 read_value(const JsonNode& value, const SampleField& field) const {
    if (field.width == 3 && value.is_array()) return value.vector(field.low, field.high);
    if (value.is_number()) return vec3(value.number(field.low, field.high));
    throw value.error(
        "is not a number",
        fmt::format("give {} within [{:g}, {:g}] or {{\"texture\": ...}}",
                    field.width == 3 ? "three numbers" : "a number", field.low, field.high));
  }

  void read_parameter(const JsonNode& value, const SampleField& field) {
    MaterialParameter parameter;
    parameter.name = field.name;
    if (value.is_object()) {
      std::vector<std::string_view> keys = {"texture", "scale", "srgb", "color_space"};
      if (field.width == 1) keys.push_back("channel");
      value.expect_keys(keys);
      // A texture's values lie in [0, 1], so 1 is the natural factor where the range allows it.
      parameter.value = vec3(std::clamp(1.0f, field.low, field.high));
      if (const auto scale = value.find("scale")) parameter.value = read_value(*scale, field);
      bool srgb = field.width == 3 && field.kind == FieldKind::linear;
      value.read("srgb", srgb);
      value.read("channel", parameter.channel, channel_labels);
      std::string color_space;
      value.read("color_space", color_space, max_name_length);
      if (!color_space.empty() && value.has("srgb")) {
        throw value.error("has srgb beside color_space", "keep one of them");
      }
      parameter.texture = read_texture(value, srgb || !color_space.empty(), color_space);
    } else {
      parameter.value = read_value(value, field);
    }
    material_.parameters.push_back(std::move(parameter));
  }

  int read_texture(const JsonNode& owner, bool srgb, const std::string& color_space = "") {
    const JsonNode texture = owner.get("texture", "name an image file");
    return add_texture(scene_, read_path(texture, folder_), srgb, texture.place(), color_space);
  }

  void read_alpha(const JsonNode& alpha) {
    alpha.expect_keys({"texture", "cutoff", "from"});
    set_alpha_mask(scene_, read_texture(alpha, false), material_);
    alpha.read("cutoff", material_.alpha_cutoff, 0, 1);
    alpha.read("from", material_.alpha_from_luminance, mask_labels);
  }

  void read_normal_map(const JsonNode& map) {
    map.expect_keys({"texture", "scale"});
    material_.normal_texture = read_texture(map, false);
    map.read("scale", material_.normal_scale, -1000, 1000);
  }

  /// As a parameter is read, of any size.
  void read_emission(const JsonNode& value) {
    constexpr SampleField field{
        "emission",     3, FieldKind::linear, FieldSource::material, "radiance",
        Merge::average, 0, max_emission};
    read_parameter(value, field);
    material_.emission = material_.parameters.back().value;
    material_.emission_texture = material_.parameters.back().texture;
    material_.parameters.pop_back();
  }

  void read_merges(const JsonNode& merges) {
    std::vector<std::string_view> keys;
    for (const SampleField& field : shader().fields) {
      // A position is always a real sample's: it cannot be averaged.
      if (field.kind != FieldKind::anchor) keys.push_back(field.name);
    }
    merges.expect_keys(keys);
    for (const auto& [name, value] : merges.members()) {
      material_.merges.emplace_back(name, value.label(merge_labels));
    }
  }

  static constexpr std::array channel_labels = {Label<int>{0, "r"}, Label<int>{1, "g"},
                                                Label<int>{2, "b"}, Label<int>{3, "a"}};
  static constexpr std::array mask_labels = {
      Label<bool>{false, "alpha"},
      Label<bool>{true, "luminance"},
  };

  const JsonNode& node_;
  const std::filesystem::path& folder_;
  Scene& scene_;
  Material material_;
};

}  // namespace

uint32_t MaterialNames::find(const JsonNode& node) const {
  const std::string name = node.text(max_name_length);
  if (const auto found = indices_.find(name); found != indices_.end()) return found->second;
  std::string names;
  for (const auto& [known, index] : indices_) {
    names += (names.empty() ? "" : ", ") + known;
  }
  throw node.error(fmt::format("\"{}\" is no material of this file", name),
                   names.empty() ? "add it to \"materials\"" : "give one of: " + names);
}

std::filesystem::path read_path(const JsonNode& node, const std::filesystem::path& folder) {
  return folder / std::filesystem::path(node.text(4096));
}

MaterialNames read_materials(const JsonNode& list, const std::filesystem::path& folder,
                             Scene& scene) {
  MaterialNames names;
  for (const JsonNode& node : list.items(max_materials)) {
    Material material = MaterialReader(node, folder, scene).read();
    if (names.has(material.name)) {
      throw node.get("name", "")
          .error(fmt::format("\"{}\" is taken by another material", material.name),
                 "give each material its own name");
    }
    names.add(material.name, static_cast<uint32_t>(scene.materials.size()));
    scene.materials.push_back(std::move(material));
  }
  return names;
}

}  // namespace relume

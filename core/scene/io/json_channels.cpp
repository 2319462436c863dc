#include <fmt/format.h>

#include "core/base/file.h"
#include "core/scene/channel_map.h"
#include "core/scene/io/json_node.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr uint64_t max_map_bytes = uint64_t{1} << 20;

struct Preset {
  std::string_view name;
  std::string_view text;
};

constexpr std::array<Preset, 4> presets = {{
    {"cycles", R"({"coverage": "Combined.A", "types": [{"shader": "lambert", "fields": {
        "position": "Position", "normal": "Normal", "diffuse": "DiffCol"}}]})"},
    {"arnold", R"({"coverage": "A", "types": [{"shader": "lambert", "fields": {
        "position": "P", "normal": "N", "diffuse": "diffuse_albedo"}}]})"},
    {"renderman", R"({"coverage": "a", "types": [{"shader": "lambert", "fields": {
        "position": "__Pworld", "normal": "__Nworld", "diffuse": "albedo"}}]})"},
    // What `relume sample` writes.
    {"relume", R"({"id": "id", "types": [
        {"id": 1, "shader": "lambert", "fields": {"position": "P", "bias": "bias", "normal": "N",
          "diffuse": "diffuse"}},
        {"id": 2, "shader": "phong", "fields": {"position": "P", "bias": "bias", "normal": "N",
          "diffuse": "diffuse", "specular": "specular", "exponent": "exponent"}},
        {"id": 3, "shader": "kajiya-kay", "fields": {"position": "P", "bias": "bias",
          "tangent": "T", "diffuse": "diffuse", "specular": "specular", "exponent": "exponent"}},
        {"id": 4, "shader": "leaf", "fields": {"position": "P", "bias": "bias", "normal": "N",
          "diffuse": "diffuse", "transmit": "transmit"}},
        {"id": 5, "shader": "ggx", "fields": {"position": "P", "bias": "bias", "normal": "N",
          "diffuse": "diffuse", "specular": "specular", "reflectance": "reflectance",
          "roughness": "roughness"}}]})"},
}};

class ChannelMapReader {
 public:
  ChannelMapReader(const JsonNode& root, std::span<const ShaderInfo* const> shaders)
      : root_(root), shaders_(shaders) {}

  ChannelMap read() const {
    root_.expect_keys({"coverage", "id", "types"});
    ChannelMap map;
    root_.read("coverage", map.coverage, max_name_length);
    root_.read("id", map.id, max_name_length);
    const JsonNode types = root_.get("types", "give \"types\": [ ... ]");
    for (const JsonNode& node : types.items(64)) map.types.push_back(read_type(node, map));
    if (map.types.empty()) throw types.error("is empty", "give at least one type");
    if (map.id.empty() && map.types.size() > 1) {
      throw types.error("has several types", "give \"id\", the channel that tells them apart");
    }
    return map;
  }

 private:
  ChannelType read_type(const JsonNode& node, const ChannelMap& map) const {
    node.expect_keys({"id", "shader", "fields"});
    ChannelType type;
    type.shader = find_shader(node.get("shader", "name the shader of these samples"));
    if (!map.id.empty()) {
      type.id = node.get("id", "give the value of the id channel").number(-1e9f, 1e9f);
    }
    const JsonNode fields = node.get("fields", "give \"fields\": { ... }");
    for (const auto& [name, value] : fields.members()) {
      type.fields.push_back(read_field(name, value, *type.shader));
    }
    for (const SampleField& field : type.shader->fields) check_given(fields, field);
    return type;
  }

  const ShaderInfo* find_shader(const JsonNode& node) const {
    const std::string name = node.text(max_name_length);
    std::string known;
    for (const ShaderInfo* shader : shaders_) {
      if (shader->name == name) return shader;
      known += fmt::format("{}{}", known.empty() ? "" : ", ", shader->name);
    }
    throw node.error(fmt::format("\"{}\" is unknown", name), "give one of: " + known);
  }

  static ChannelSource read_field(const std::string& name, const JsonNode& value,
                                  const ShaderInfo& shader) {
    auto field = std::ranges::find(shader.fields, std::string_view(name), &SampleField::name);
    if (field == shader.fields.end() && name == "roughness") {
      field = std::ranges::find(shader.fields, std::string_view("exponent"), &SampleField::name);
    }
    if (field == shader.fields.end()) {
      throw value.error(fmt::format("the shader {} has no such field", shader.name),
                        "leave it out");
    }
    ChannelSource source{name, "", vec3(0)};
    if (value.is_string()) {
      source.layer = value.text(max_name_length);
    } else if (field->width == 3) {
      source.constant = value.vector(-max_coordinate, max_coordinate);
    } else {
      source.constant = vec3(value.number(0, max_coordinate));
    }
    return source;
  }

  /// Position, normal and tangent have no initial value to fall back on.
  static void check_given(const JsonNode& fields, const SampleField& field) {
    const bool is_needed = field.source == FieldSource::position ||
                           field.source == FieldSource::normal ||
                           field.source == FieldSource::tangent;
    if (!is_needed) return;
    const JsonNode node =
        fields.get(field.name, fmt::format("give the layer of the {}", field.name));
    if (!node.is_string()) throw node.error("is no layer", "name the layer that holds it");
  }

  JsonNode root_;
  std::span<const ShaderInfo* const> shaders_;
};

}  // namespace

std::vector<std::string> channel_preset_names() {
  std::vector<std::string> names;
  for (const Preset& preset : presets) names.emplace_back(preset.name);
  return names;
}

ChannelMap load_channel_map(const std::string& preset_or_path,
                            std::span<const ShaderInfo* const> shaders) {
  for (const Preset& preset : presets) {
    if (preset.name != preset_or_path) continue;
    const JsonDocument document(std::string(preset.text), "preset " + preset_or_path);
    return ChannelMapReader(document.root(), shaders).read();
  }
  const JsonDocument document(read_text_file(preset_or_path, max_map_bytes), preset_or_path);
  return ChannelMapReader(document.root(), shaders).read();
}

}  // namespace relume

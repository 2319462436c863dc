#include "core/scene/io/json_lights.h"

#include <fmt/format.h>

#include "core/scene/io/json_light_animation.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

/// "gain", or "gain_relative": multiplied by radius^2 where the light falls off with distance, so
/// that the picture's exposure does not depend on the scene's units.
void read_gain(const JsonNode& node, const std::optional<SceneFrame>& frame, Light& light) {
  const auto relative = node.find("gain_relative");
  if (!relative) {
    node.read("gain", light.gain, 0, max_light_gain);
    return;
  }
  if (node.has("gain")) throw relative->error("stands beside \"gain\"", "keep one of them");
  if (!frame) {
    throw relative->error("needs a scene's bounds", "give \"gain\" in a file of lights only");
  }
  const bool falls_off = light.falloff && light.type != LightType::directional;
  const float unit = falls_off ? frame->radius * frame->radius : 1.0f;
  light.gain = relative->number(0, max_light_gain) * unit;
}

/// "direction", or "target": the point that the light is aimed at.
void read_direction(const JsonNode& node, const std::optional<SceneFrame>& frame, Light& light) {
  const auto target = node.find("target");
  if (!target) {
    node.read("direction", light.direction, -max_coordinate, max_coordinate);
    return;
  }
  if (node.has("direction")) {
    throw target->error("stands beside \"direction\"", "keep one of them");
  }
  light.direction = read_position(*target, frame) - light.position;
  if (light.direction == vec3(0)) {
    throw target->error("is where the light is", "move the target or the light");
  }
}

Light read_light(const JsonNode& node, const std::optional<SceneFrame>& frame) {
  node.expect_keys({"name", "type", "position", "direction", "target", "inner_angle_deg",
                    "outer_angle_deg", "falloff", "range", "color", "gain", "gain_relative", "mute",
                    "casts_shadow", "keyframes", "turntable"});
  Light light;
  node.read("name", light.name, max_name_length);
  node.read("type", light.type, light_type_labels);
  if (const auto position = node.find("position")) light.position = read_position(*position, frame);
  read_direction(node, frame, light);
  node.read("outer_angle_deg", light.outer_angle_deg, min_spot_angle_deg, 90);
  light.inner_angle_deg = std::min(light.inner_angle_deg, light.outer_angle_deg);
  node.read("inner_angle_deg", light.inner_angle_deg, 0, 90);
  node.read("falloff", light.falloff);
  node.read("range", light.range, 0, 1e15f);
  node.read("color", light.color, 0, max_light_gain);
  read_gain(node, frame, light);
  node.read("mute", light.mute);
  node.read("casts_shadow", light.casts_shadow);
  validate_light(light, node.place());
  read_light_animation(node);  // says what is wrong with it
  return light;
}

std::string format_light(const Light& light) {
  std::string out = fmt::format("    {{\"name\": {}, \"type\": \"{}\",", json_quoted(light.name),
                                label_of(light_type_labels, light.type));
  out += fmt::format(" \"position\": {}, \"direction\": {},", json_vector(light.position),
                     json_vector(light.direction));
  out += fmt::format(" \"inner_angle_deg\": {}, \"outer_angle_deg\": {}, \"falloff\": {},",
                     json_number(light.inner_angle_deg), json_number(light.outer_angle_deg),
                     light.falloff);
  if (light.range > 0) out += fmt::format(" \"range\": {},", json_number(light.range));
  out += fmt::format(" \"color\": {}, \"gain\": {}, \"mute\": {}, \"casts_shadow\": {}}}",
                     json_vector(light.color), json_number(light.gain), light.mute,
                     light.casts_shadow);
  return out;
}

}  // namespace

vec3 read_position(const JsonNode& node, const std::optional<SceneFrame>& frame) {
  if (!node.is_object()) return node.vector(-max_coordinate, max_coordinate);
  node.expect_keys({"relative"});
  const JsonNode relative = node.get("relative", "give {\"relative\": [x, y, z]}");
  const vec3 v = relative.vector(-1e6f, 1e6f);
  if (!frame) {
    throw relative.error("needs a scene's bounds",
                         "give world coordinates in a file of lights only");
  }
  return frame->center + frame->radius * v;
}

std::vector<Light> read_lights(const JsonNode& list, const std::optional<SceneFrame>& frame) {
  std::vector<Light> lights;
  for (const JsonNode& item : list.items(max_lights)) {
    Light light = read_light(item, frame);
    if (!item.has("name")) light.name = fmt::format("light-{}", lights.size() + 1);
    // Names become EXR layers "light.NAME.R": a dot would split them.
    if (light.name.find('.') != std::string::npos) {
      throw item.get("name", "").error("holds a dot", "names become EXR layers: leave dots out");
    }
    const bool taken = std::any_of(lights.begin(), lights.end(),
                                   [&](const Light& other) { return other.name == light.name; });
    if (taken) {
      throw item.error(fmt::format("the name \"{}\" is taken by another light", light.name),
                       "give each light its own name");
    }
    lights.push_back(std::move(light));
  }
  return lights;
}

std::pair<Light, Light> read_representatives(const JsonNode& list, const SceneFrame& frame) {
  const std::vector<JsonNode> items = list.items(max_lights);
  if (items.size() != 2) {
    throw list.error(fmt::format("holds {} lights", items.size()),
                     "give two: the low and the high corner of the training lights");
  }
  std::pair<Light, Light> pair{read_light(items[0], frame), read_light(items[1], frame)};
  if (!items[0].has("name")) pair.first.name = "low";
  if (!items[1].has("name")) pair.second.name = "high";
  if (!can_interpolate(pair.first, pair.second)) {
    throw list.error("the two differ in type, falloff, casts_shadow or in having a range",
                     "give them the same: only numbers are interpolated");
  }
  return pair;
}

std::pair<Light, Light> default_representatives(const SceneFrame& frame) {
  Light low;
  low.name = "low";
  low.position = frame.center + frame.radius * vec3(-2.5f, 1.2f, -2.5f);
  low.gain = 10 * frame.radius * frame.radius;
  Light high = low;
  high.name = "high";
  high.position = frame.center + frame.radius * vec3(2.5f, 3.0f, 2.5f);
  return {low, high};
}

std::string format_lights(const std::vector<Light>& lights) {
  std::string out = "{\n  \"lights\": [";
  for (size_t i = 0; i < lights.size(); ++i) {
    out += (i == 0 ? "\n" : ",\n") + format_light(lights[i]);
  }
  return out + (lights.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

std::vector<Light> parse_lights(const std::string& text, const std::string& place) {
  const JsonDocument document(text, place);
  const JsonNode root = document.root();
  const bool whole_scene = root.is_object() && root.has("geometry");
  if (!whole_scene) root.expect_keys({"$schema", "name", "lights"});
  return read_lights(root.get("lights", "give \"lights\": [ ... ]"), std::nullopt);
}

}  // namespace relume

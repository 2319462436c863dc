#include "core/scene/io/json_light_animation.h"

#include <fmt/format.h>

#include "core/scene/io/load_light_animations.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr uint64_t max_keyframes = 100000;
constexpr float max_frame = 1e6f;

/// [[frame, value], ...]; read_value(node) reads one value.
template <class Value, class ReadValue>
void read_keyframes(const JsonNode& object, std::string_view key, Keyframes<Value>& keyframes,
                    const ReadValue& read_value) {
  const auto list = object.find(key);
  if (!list) return;
  for (const JsonNode& item : list->items(max_keyframes)) {
    const std::vector<JsonNode> pair = item.items(2);
    if (pair.size() != 2) throw item.error("is no keyframe", "give [frame, value]");
    const float frame = pair[0].number(-max_frame, max_frame);
    if (!keyframes.empty() && frame <= keyframes.back().first) {
      throw pair[0].error("does not come after the frame before it", "sort the keyframes");
    }
    keyframes.emplace_back(frame, read_value(pair[1]));
  }
  if (keyframes.empty()) throw list->error("is empty", "give [[frame, value], ...]");
}

Turntable read_turntable(const JsonNode& node) {
  node.expect_keys({"center", "axis", "frames", "degrees"});
  Turntable turntable;
  node.read("center", turntable.center, -max_coordinate, max_coordinate);
  node.read("axis", turntable.axis, -max_coordinate, max_coordinate);
  turntable.axis = normalize_or(turntable.axis, vec3(0));
  if (turntable.axis == vec3(0)) {
    throw node.get("axis", "").error("is zero", "give three numbers, not all zero");
  }
  const JsonNode frames = node.get("frames", "give [first, last]: the frames of the turn");
  const vec2 range = frames.pair(-max_frame, max_frame);
  if (!(range.x < range.y)) throw frames.error("do not ascend", "give [first, last]");
  turntable.first = range.x;
  turntable.last = range.y;
  node.read("degrees", turntable.degrees, -1e6f, 1e6f);
  return turntable;
}

void read_all_keyframes(const JsonNode& node, LightAnimation& animation) {
  node.expect_keys({"position", "direction", "target", "color", "gain", "inner_angle_deg",
                    "outer_angle_deg", "range"});
  const auto number = [](float low, float high) {
    return [low, high](const JsonNode& value) { return value.number(low, high); };
  };
  const auto vector = [](float low, float high) {
    return [low, high](const JsonNode& value) { return value.vector(low, high); };
  };
  const auto coordinates = vector(-max_coordinate, max_coordinate);
  read_keyframes(node, "position", animation.position, coordinates);
  read_keyframes(node, "direction", animation.direction, coordinates);
  read_keyframes(node, "target", animation.target, coordinates);
  read_keyframes(node, "color", animation.color, vector(0, max_light_gain));
  read_keyframes(node, "gain", animation.gain, number(0, max_light_gain));
  read_keyframes(node, "inner_angle_deg", animation.inner_angle_deg, number(0, 90));
  read_keyframes(node, "outer_angle_deg", animation.outer_angle_deg,
                 number(min_spot_angle_deg, 90));
  read_keyframes(node, "range", animation.range, number(0, 1e15f));
}

}  // namespace

LightAnimation read_light_animation(const JsonNode& light) {
  LightAnimation animation;
  if (const auto node = light.find("keyframes")) read_all_keyframes(*node, animation);
  if (const auto node = light.find("turntable")) animation.turntable = read_turntable(*node);
  animation.keeps_target = light.has("target");
  const bool aims = animation.keeps_target || !animation.target.empty();
  if (aims && !animation.direction.empty()) {
    throw light.get("keyframes", "").error("has a direction beside a target", "keep one of them");
  }
  return animation;
}

std::vector<LightAnimation> parse_light_animations(const std::string& text,
                                                   const std::string& place) {
  const JsonDocument document(text, place);
  const auto list = document.root().find("lights");
  std::vector<LightAnimation> animations;
  if (!list) return animations;
  for (const JsonNode& light : list->items(max_lights)) {
    animations.push_back(read_light_animation(light));
  }
  return animations;
}

}  // namespace relume

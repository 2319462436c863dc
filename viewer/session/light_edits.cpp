#include "viewer/session/light_edits.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr float max_gain = 1e20f;
constexpr float min_range = 1e-15f;
constexpr float max_range = 1e15f;

bool has_selection(const ViewState& view) {
  return view.selected_light >= 0 && view.selected_light < static_cast<int>(view.lights.size());
}

bool is_taken(const ViewState& view, const std::string& name, int except) {
  for (int i = 0; i < static_cast<int>(view.lights.size()); ++i) {
    if (i != except && view.lights[static_cast<size_t>(i)].name == name) return true;
  }
  return false;
}

/// `wanted`, or with a number behind it where another light has that name.
std::string unique_name(const ViewState& view, const std::string& wanted, int except = -1) {
  std::string stem = wanted.substr(0, max_name_length - 8);
  if (!is_taken(view, stem, except)) return stem;
  while (!stem.empty() && stem.back() >= '0' && stem.back() <= '9') stem.pop_back();
  if (stem.empty() || stem.back() != '-') stem += '-';
  int number = 2;
  while (is_taken(view, fmt::format("{}{}", stem, number), except)) ++number;
  return fmt::format("{}{}", stem, number);
}

/// Inserts `light` at `place` and selects it.
void insert_light(ViewState& view, int place, Light light) {
  view.lights.insert(view.lights.begin() + place, std::move(light));
  for (int& solo : view.solo_lights) solo += solo >= place ? 1 : 0;
  view.selected_light = place;
}

vec3 limit_vector(vec3 v, vec3 before, float low, float high) {
  return is_finite(v) ? glm::clamp(v, vec3(low), vec3(high)) : before;
}

float limit_number(float x, float before, float low, float high) {
  return is_finite(x) ? std::clamp(x, low, high) : before;
}

}  // namespace

void add_light(ViewState& view, const Bounds& bounds, const Camera& camera) {
  if (view.lights.size() >= max_lights) return;
  const float radius = std::max(bounds.radius(), 1e-6f);
  const CameraRays rays(camera, 2, 2);
  const vec3 offset = -rays.forward() - 0.6f * rays.right() + 0.8f * rays.up();
  Light light;
  light.name = unique_name(view, fmt::format("light-{}", view.lights.size() + 1));
  light.position = bounds.center() + radius * 2.0f * offset;
  light.direction = -offset;
  const float distance = 2.0f * radius * glm::length(offset);
  light.gain = std::min(pi * distance * distance, max_gain);
  limit_light(light, Light{});
  insert_light(view, static_cast<int>(view.lights.size()), light);
}

void duplicate_light(ViewState& view) {
  if (!has_selection(view) || view.lights.size() >= max_lights) return;
  const int original = view.selected_light;
  Light copy = view.lights[static_cast<size_t>(original)];
  copy.name = unique_name(view, copy.name);
  const bool solo = is_solo(view, original);
  insert_light(view, original + 1, std::move(copy));
  if (solo) toggle_solo(view, original + 1);
}

void delete_light(ViewState& view) {
  if (!has_selection(view)) return;
  const int gone = view.selected_light;
  if (is_solo(view, gone)) toggle_solo(view, gone);
  view.lights.erase(view.lights.begin() + gone);
  for (int& solo : view.solo_lights) solo -= solo > gone ? 1 : 0;
  view.selected_light = std::min(gone, static_cast<int>(view.lights.size()) - 1);
}

void reorder_light(ViewState& view, int steps) {
  if (!has_selection(view)) return;
  const int count = static_cast<int>(view.lights.size());
  const int direction = steps < 0 ? -1 : 1;
  for (int i = 0; i != steps; i += direction) {
    const int from = view.selected_light;
    const int to = from + direction;
    if (to < 0 || to >= count) return;
    std::swap(view.lights[static_cast<size_t>(from)], view.lights[static_cast<size_t>(to)]);
    if (is_solo(view, from) != is_solo(view, to)) {
      toggle_solo(view, from);
      toggle_solo(view, to);
    }
    view.selected_light = to;
  }
}

void select_next_light(ViewState& view, int steps) {
  const int count = static_cast<int>(view.lights.size());
  if (count == 0) return;
  const int from = has_selection(view) ? view.selected_light : (steps > 0 ? -1 : 0);
  view.selected_light = ((from + steps) % count + count) % count;
}

void toggle_solo(ViewState& view, int light) {
  if (light < 0 || light >= static_cast<int>(view.lights.size())) return;
  const auto place = std::lower_bound(view.solo_lights.begin(), view.solo_lights.end(), light);
  if (place != view.solo_lights.end() && *place == light) {
    view.solo_lights.erase(place);
  } else {
    view.solo_lights.insert(place, light);
  }
}

bool is_solo(const ViewState& view, int light) {
  return std::binary_search(view.solo_lights.begin(), view.solo_lights.end(), light);
}

void rename_light(ViewState& view, int light, const std::string& name) {
  if (light < 0 || light >= static_cast<int>(view.lights.size())) return;
  std::string clean = printable(name, max_name_length - 16);
  std::replace(clean.begin(), clean.end(), '.', '_');
  if (clean.find_first_not_of(' ') == std::string::npos) return;
  view.lights[static_cast<size_t>(light)].name = unique_name(view, clean, light);
}

void limit_light(Light& light, const Light& before) {
  light.position = limit_vector(light.position, before.position, -max_coordinate, max_coordinate);
  light.direction =
      limit_vector(light.direction, before.direction, -max_coordinate, max_coordinate);
  if (!(glm::length(dvec3(light.direction)) > 0)) light.direction = before.direction;
  light.outer_angle_deg =
      limit_number(light.outer_angle_deg, before.outer_angle_deg, min_spot_angle_deg, 90);
  light.inner_angle_deg =
      limit_number(light.inner_angle_deg, before.inner_angle_deg, 0, light.outer_angle_deg);
  light.inner_angle_deg = std::min(light.inner_angle_deg, light.outer_angle_deg);
  light.color = limit_vector(light.color, before.color, 0, max_gain);
  light.gain = limit_number(light.gain, before.gain, 0, max_gain);
  light.range = limit_number(light.range, before.range, 0, max_range);
  if (light.range < min_range) light.range = 0;
}

void set_light_type(Light& light, LightType type, const Bounds& bounds) {
  // A point light's direction says nothing: start by aiming at the scene.
  if (light.type == LightType::point && type != LightType::point) {
    light.direction = normalize_or(bounds.center() - light.position, light.direction);
  }
  light.type = type;
}

}  // namespace relume

#include "viewer/study/shadow_lights.h"

#include <algorithm>

#include "core/scene/camera.h"

namespace relume {
namespace {

constexpr int focus_rays = 64;  ///< a side

float median(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

vec3 median_position(std::span<const vec3> points) {
  vec3 result(0);
  std::vector<float> values(points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (size_t i = 0; i < points.size(); ++i) values[i] = points[i][axis];
    result[axis] = median(values);
  }
  return result;
}

Light make_point(const std::string& name, vec3 position, float irradiance_distance) {
  Light light;
  light.name = name;
  light.position = position;
  light.gain = irradiance_distance * irradiance_distance;
  return light;
}

/// `light`, moved by `angle_rad` around the centre; directional lights turn. Steps go sideways and
/// down, so that no axis is preferred.
Light moved_light(Light light, const ViewFocus& focus, float angle_rad, vec3 right, vec3 up) {
  const vec3 sideways = normalize_or(right - 0.6f * up, right);
  if (light.type == LightType::directional) {
    light.direction =
        normalize_or(normalize_or(light.direction, -up) + angle_rad * sideways, light.direction);
    return light;
  }
  const float distance = std::max(glm::length(light.position - focus.center), focus.radius);
  light.position += angle_rad * distance * sideways;
  return light;
}

}  // namespace

ViewFocus find_focus(const Scene& scene, const Tracer& tracer, int width, int height) {
  const CameraRays rays(scene.camera, width, height);
  std::vector<vec3> hits;
  ViewFocus focus;
  float nearest = std::numeric_limits<float>::infinity();
  for (int y = 0; y < focus_rays; ++y) {
    for (int x = 0; x < focus_rays; ++x) {
      const vec2 at = (vec2(x, y) + 0.5f) / float{focus_rays};
      const auto hit = tracer.intersect(
          {.origin = rays.eye(), .direction = rays.direction(at * vec2(width, height))});
      if (!hit) continue;
      hits.push_back(hit->position);
      const float from_middle = glm::length(at - 0.5f);
      if (from_middle >= nearest) continue;
      nearest = from_middle;
      focus.point = hit->position;
    }
  }
  focus.empty = hits.empty();
  if (focus.empty) return focus;
  focus.center = median_position(hits);
  std::vector<float> distances(hits.size());
  for (size_t i = 0; i < hits.size(); ++i) distances[i] = glm::length(hits[i] - focus.center);
  focus.radius = std::max(1.5f * median(distances), 1e-6f * tracer.bounds().radius());
  focus.pixel = rays.footprint_per_depth() * glm::length(focus.center - rays.eye());
  return focus;
}

std::vector<StudyLight> make_study_lights(const Scene& scene, const ViewFocus& focus, int steps) {
  const CameraRays rays(scene.camera, scene.width, scene.height);
  const vec3 right = rays.right();
  const vec3 up = normalize_or(scene.camera.up, rays.up());
  const vec3 to_eye = normalize_or(glm::cross(right, up), -rays.forward());
  const float r = focus.radius;
  const auto place = [&](float x, float y, float z) {
    return focus.center + r * (x * right + y * up + z * to_eye);
  };
  Light sun;
  sun.name = "directional";
  sun.type = LightType::directional;
  sun.direction = -normalize_or(0.6f * right + 0.7f * up + 0.4f * to_eye, up);
  const vec3 off_surface = normalize_or(0.5f * up + to_eye, up) * (r / 12);
  const Light lights[] = {
      make_point("beside", place(2.2f, 2, 2.2f), 3.7f * r),
      make_point("low", place(-2.6f, 0.35f, -1.2f), 2.9f * r),
      make_point("overhead", place(0.1f, 3, 0.1f), 3 * r),
      make_point("inside", focus.point + off_surface, 0.25f * r),
      sun,
  };
  const float angle_rad = focus.pixel / r;
  std::vector<StudyLight> study;
  for (const Light& light : lights) {
    StudyLight& added = study.emplace_back(StudyLight{light.name, {light}});
    for (int i = 1; i <= steps; ++i) {
      added.path.push_back(moved_light(light, focus, angle_rad * static_cast<float>(i), right, up));
    }
  }
  return study;
}

}  // namespace relume

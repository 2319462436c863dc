#include "viewer/session/light_placement.h"

#include "core/scene/limits.h"
#include "core/trace/ray_bias.h"

namespace relume {
namespace {

constexpr float rim_elevation_deg = 15;    // of the light over the surface
constexpr float nearest_distance = 1e-3f;  // of the scene's radius

bool is_strand(const SurfacePoint& surface) {
  return surface.geometric_normal == vec3(0);
}

/// The part of `v` that is perpendicular to the unit vector `axis`, as a unit vector.
vec3 perpendicular_part(vec3 v, vec3 axis) {
  const vec3 other = std::abs(axis.x) < 0.6f ? vec3(1, 0, 0) : vec3(0, 1, 0);
  const vec3 fallback = glm::normalize(glm::cross(axis, other));
  const vec3 part = v - axis * glm::dot(v, axis);
  return glm::length(part) > 1e-4f ? normalize_or(part, fallback) : fallback;
}

/// Unit vector to the light, and its distance (directional: the scene's radius).
struct LightSide {
  vec3 direction;
  float distance;
};

LightSide light_side(const Light& light, vec3 p_world, float radius) {
  if (light.type == LightType::directional) {
    return {-normalize_or(light.direction, vec3(0, -1, 0)), radius};
  }
  const vec3 v = light.position - p_world;
  return {normalize_or(v, vec3(0, 1, 0)), std::max(glm::length(v), nearest_distance * radius)};
}

/// `wi`: where the light is now; `wo`: to the eye.
vec3 highlight_direction(const SurfacePoint& surface, vec3 wi, vec3 wo) {
  if (!is_strand(surface)) {
    const vec3 n = surface.shading_normal;
    return 2 * glm::dot(n, wo) * n - wo;
  }
  const vec3 t = surface.tangent;
  const float along = -glm::dot(t, wo);
  return along * t + std::sqrt(std::max(0.0f, 1 - along * along)) * perpendicular_part(wi, t);
}

vec3 diffuse_direction(const SurfacePoint& surface, vec3 wi) {
  return is_strand(surface) ? perpendicular_part(wi, surface.tangent) : surface.shading_normal;
}

vec3 rim_direction(const SurfacePoint& surface, vec3 wi, vec3 wo) {
  const vec3 n = surface.shading_normal;
  // Where the surface faces the eye every side is behind: the light's own is taken.
  const vec3 behind = std::abs(glm::dot(n, wo)) > 0.98f ? wi : -wo;
  const float elevation = radians_from_degrees(rim_elevation_deg);
  return std::cos(elevation) * perpendicular_part(behind, n) + std::sin(elevation) * n;
}

void point_at(Light& light, vec3 direction) {
  if (light.type != LightType::point) light.direction = direction;
}

}  // namespace

std::optional<SurfacePoint> find_surface(const Tracer& tracer, const CameraRays& rays,
                                         vec2 film_px) {
  return tracer.intersect({.origin = rays.eye(), .direction = rays.direction(film_px)});
}

void place_light(Light& light, PlaceTool tool, const SurfacePoint& surface, vec3 eye,
                 const Bounds& bounds) {
  const float radius = std::max(bounds.radius(), 1e-6f);
  const LightSide side = light_side(light, surface.position, radius);
  const vec3 wo = normalize_or(eye - surface.position, surface.shading_normal);
  vec3 wi = side.direction;
  switch (tool) {
    case PlaceTool::highlight:
      wi = highlight_direction(surface, wi, wo);
      break;
    case PlaceTool::diffuse:
      wi = diffuse_direction(surface, wi);
      break;
    case PlaceTool::rim:
      wi = rim_direction(surface, wi, wo);
      break;
    case PlaceTool::none:
    case PlaceTool::shadow:
      return;
  }
  wi = normalize_or(wi, side.direction);
  if (light.type != LightType::directional) {
    light.position = glm::clamp(surface.position + wi * side.distance, vec3(-max_coordinate),
                                vec3(max_coordinate));
  }
  point_at(light, -wi);
}

std::optional<ShadowGrip> grab_shadow(const Tracer& tracer, const SurfacePoint& surface,
                                      const Light& light) {
  const bool is_directional = light.type == LightType::directional;
  const LightSide side = light_side(light, surface.position, tracer.bounds().radius());
  const float distance = is_directional ? std::numeric_limits<float>::infinity() : side.distance;
  const vec3* normal = is_strand(surface) ? nullptr : &surface.shading_normal;
  const auto occluder = tracer.intersect(
      make_shadow_ray(surface.position, normal, surface.bias, side.direction, distance));
  if (!occluder) return std::nullopt;
  return ShadowGrip{occluder->position, side.distance};
}

void drag_shadow(Light& light, const ShadowGrip& grip, vec3 receiver) {
  const vec3 v = grip.occluder - receiver;
  const float length = glm::length(v);
  if (!(length > 0) || !is_finite(length)) return;
  const vec3 wi = v / length;
  if (light.type != LightType::directional) {
    // The light stays behind what casts the shadow.
    const float distance = std::max(grip.distance, 1.01f * length);
    light.position =
        glm::clamp(receiver + wi * distance, vec3(-max_coordinate), vec3(max_coordinate));
  }
  point_at(light, -wi);
}

}  // namespace relume

#include "viewer/session/light_motion.h"

#include "core/scene/limits.h"

namespace relume {

vec3 light_handle(const Light& light, const Bounds& bounds) {
  if (light.type != LightType::directional) return light.position;
  const float radius = std::max(bounds.radius(), 1e-6f);
  return bounds.center() - normalize_or(light.direction, vec3(0, -1, 0)) * radius;
}

void set_light_handle(Light& light, const Bounds& bounds, vec3 p_world) {
  if (!is_finite(p_world)) return;
  if (light.type != LightType::directional) {
    light.position = glm::clamp(p_world, vec3(-max_coordinate), vec3(max_coordinate));
    return;
  }
  light.direction = normalize_or(bounds.center() - p_world, light.direction);
}

vec3 move_in_view_plane(const CameraRays& rays, vec3 p_world, vec2 delta_px) {
  const float depth = rays.project(p_world).depth;
  if (!(depth > 0)) return p_world;
  const float world_per_px = rays.footprint_per_depth() * depth;
  return p_world + (rays.right() * delta_px.x - rays.up() * delta_px.y) * world_per_px;
}

vec3 move_along_axis(const CameraRays& rays, vec3 p_world, vec3 axis, float unit, vec2 delta_px) {
  const CameraRays::Projection from = rays.project(p_world);
  const CameraRays::Projection to = rays.project(p_world + axis * unit);
  if (!(from.depth > 0) || !(to.depth > 0)) return p_world;
  const vec2 axis_px = to.film_px - from.film_px;
  const float length_squared = glm::dot(axis_px, axis_px);
  if (!(length_squared >= 1)) return p_world;
  return p_world + axis * (unit * glm::dot(delta_px, axis_px) / length_squared);
}

vec3 move_as_target(const CameraRays& rays, const Camera& camera, vec3 p_world, vec3 motion) {
  const float depth = rays.project(p_world).depth;
  const float measured = depth > 0 ? depth : rays.project(camera.target).depth;
  const float world_per_px = rays.footprint_per_depth() * measured;
  return (rays.right() * motion.x - rays.up() * motion.y + rays.forward() * motion.z) *
         world_per_px;
}

}  // namespace relume

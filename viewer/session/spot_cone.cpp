#include "viewer/session/spot_cone.h"

namespace relume {
namespace {

constexpr float largest_disc = 0.5f;  // radius, of the scene's
constexpr float widest_deg = 89;

}  // namespace

SpotCone make_spot_cone(const Light& light, float aim_distance, const Bounds& bounds) {
  SpotCone cone;
  cone.apex = light.position;
  cone.axis = normalize_or(light.direction, cone.axis);
  const vec3 other = std::abs(cone.axis.y) < 0.9f ? vec3(0, 1, 0) : vec3(1, 0, 0);
  cone.right = glm::normalize(glm::cross(cone.axis, other));
  cone.up = glm::cross(cone.right, cone.axis);
  const float radius = std::max(bounds.radius(), 1e-6f);
  const float angle = radians_from_degrees(std::min(light.outer_angle_deg, widest_deg));
  cone.distance =
      std::max(std::min(aim_distance, largest_disc * radius / std::tan(angle)), 1e-4f * radius);
  return cone;
}

vec3 cone_point(const SpotCone& cone, float angle_deg, float turn_rad) {
  const float angle = radians_from_degrees(std::clamp(angle_deg, 0.0f, widest_deg));
  const vec3 across = std::cos(turn_rad) * cone.right + std::sin(turn_rad) * cone.up;
  return cone.apex + cone.distance * (cone.axis + std::tan(angle) * across);
}

float cone_angle_at(const SpotCone& cone, vec3 p_world) {
  const vec3 v = p_world - cone.apex;
  const float along = glm::dot(v, cone.axis);
  const float across = glm::length(v - cone.axis * along);
  return std::atan2(across, std::max(along, 1e-6f * cone.distance)) * (180.0f / pi);
}

}  // namespace relume

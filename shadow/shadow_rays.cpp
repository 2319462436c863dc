#include "shadow/shadow_rays.h"

#include "core/trace/ray_bias.h"

namespace relume {

void ShadowRays::aim(const Light& light) {
  light_ = light;
  reach_ = reach_of(light);
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
}

bool ShadowRays::sees(vec3 position, const vec3* normal, bool lit_from_behind, float bias) const {
  vec3 wi = to_light_;
  float distance = std::numeric_limits<float>::infinity();
  if (light_.type != LightType::directional) {
    const dvec3 offset = dvec3(light_.position) - dvec3(position);
    const double length = glm::length(offset);
    if (!(length > 0)) return true;  // the light lies on the receiver: nothing is between them
    distance = static_cast<float>(length);
    wi = vec3(offset / length);
  }
  // Rays whose answer is multiplied by zero are not traced.
  if (distance > reach_) return true;
  if (light_.type == LightType::spot && glm::dot(wi, to_light_) < cos_outer_) return true;
  if (normal != nullptr && !lit_from_behind && glm::dot(*normal, wi) <= 0) return true;
  return !tracer_.occluded(make_shadow_ray(position, normal, bias, wi, distance));
}

}  // namespace relume

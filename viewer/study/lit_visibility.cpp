#include "viewer/study/lit_visibility.h"

namespace relume {

bool can_light(const Light& light, const Receivers& receivers, int lane) {
  const vec3 p(receivers.position[0][lane], receivers.position[1][lane],
               receivers.position[2][lane]);
  const vec3 to_light = -normalize_or(light.direction, vec3(0, -1, 0));
  const vec3 wi =
      light.type == LightType::directional ? to_light : vec3(dvec3(light.position) - dvec3(p));
  if (light.type == LightType::spot) {
    const float cos_outer = std::cos(radians_from_degrees(light.outer_angle_deg));
    if (glm::dot(wi, to_light) < cos_outer * glm::length(wi)) return false;
  }
  if (receivers.normal[0] == nullptr || receivers.lit_from_behind) return true;
  const vec3 n(receivers.normal[0][lane], receivers.normal[1][lane], receivers.normal[2][lane]);
  return glm::dot(n, wi) > 0;
}

void LitVisibility::visibility(const Receivers& receivers, float* visibility) const {
  source_.visibility(receivers, visibility);
  for (int lane = 0; lane < receivers.count; ++lane) {
    if (!can_light(light_, receivers, lane)) visibility[lane] = 0;
  }
}

}  // namespace relume

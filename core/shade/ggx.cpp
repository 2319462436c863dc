#include "core/shade/ggx.h"

namespace relume {

void Ggx::fields_of_parameters(const vec3* given, vec3* out) {
  const vec3 base = given[0];
  const float metallic = given[1].x;
  const float dielectric = given[2].x;
  const vec3 f0 = glm::mix(vec3(dielectric), base, metallic);
  const float reflectance = max_component(f0);
  out[0] = base * ((1 - metallic) * (1 - dielectric));
  out[1] = reflectance > 0 ? f0 / reflectance : vec3(1);
  out[2] = vec3(reflectance);
  out[3] = given[3];
}

}  // namespace relume

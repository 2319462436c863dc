#include "core/shade/ggx.h"

namespace relume {

void Ggx::fields_of_parameters(const vec3* parameters, vec3* fields) {
  const vec3 base = parameters[0];
  const float metallic = parameters[1].x;
  const float dielectric = parameters[2].x;
  const vec3 f0 = glm::mix(vec3(dielectric), base, metallic);
  const float reflectance = max_component(f0);
  fields[0] = base * ((1 - metallic) * (1 - dielectric));
  fields[1] = reflectance > 0 ? f0 / reflectance : vec3(1);
  fields[2] = vec3(reflectance);
  fields[3] = parameters[3];
}

}  // namespace relume

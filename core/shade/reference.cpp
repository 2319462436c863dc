#include "core/shade/reference.h"

#include "core/base/check.h"
#include "core/shade/shader_list.h"

namespace relume {
namespace {

using ReferenceFunction = dvec3 (*)(const double*, dvec3, dvec3);

template <class... Shaders>
ReferenceFunction find_reference(ShaderList<Shaders...>, const ShaderInfo* shader) {
  ReferenceFunction found = nullptr;
  ((shader == &Shaders::info ? (found = &Shaders::reference) : nullptr), ...);
  return found;
}

/// Smooth step from the outer to the inner cone angle, in the cosine.
double spot_factor(const Light& light, dvec3 wi) {
  const double degree = 3.14159265358979323846 / 180;
  const double cos_outer = std::cos(light.outer_angle_deg * degree);
  const double cos_inner = std::cos(light.inner_angle_deg * degree);
  const double cosine = glm::dot(wi, -glm::normalize(dvec3(light.direction)));
  if (cos_inner - cos_outer < 1e-6) return cosine >= cos_outer ? 1 : 0;
  const double t = std::clamp((cosine - cos_outer) / (cos_inner - cos_outer), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

dvec3 reference_response(const SampleType& type, const float* vector, const Light& light, dvec3 eye,
                         double scene_radius) {
  const ReferenceFunction shade = find_reference(AllShaders{}, type.shader);
  CHECK_MSG(shade != nullptr, "shader {}", type.shader->name);
  double wide[64];
  CHECK(type.width <= 64);
  for (int i = 0; i < type.width; ++i) wide[i] = vector[i];
  const dvec3 p(wide[0], wide[1], wide[2]);
  const dvec3 to_eye = eye - p;
  const double eye_distance = glm::length(to_eye);
  const dvec3 wo = eye_distance > 0 ? to_eye / eye_distance : dvec3(0);
  if (light.type == LightType::directional) {
    return shade(wide, -glm::normalize(dvec3(light.direction)), wo);
  }
  const dvec3 to_light = dvec3(light.position) - p;
  const double distance = std::max(glm::length(to_light), min_light_distance * scene_radius);
  if (!(distance > 0)) return dvec3(0);
  const dvec3 wi = to_light / distance;
  double irradiance = light.falloff ? 1 / (distance * distance) : 1.0;
  const double part = distance / reach_of(light);
  irradiance *= std::max(0.0, 1 - part * part * part * part);
  if (light.type == LightType::spot) irradiance *= spot_factor(light, wi);
  return shade(wide, wi, wo) * irradiance;
}

}  // namespace relume

#include "tests/support/response_bound.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/shade/reference.h"
#include "core/shade/shader_list.h"

namespace relume::test {
namespace {

constexpr double degree = 3.14159265358979323846 / 180;

template <class... Shaders>
dvec3 shade_directly(ShaderList<Shaders...>, const SampleType& type, const double* v, dvec3 wi,
                     dvec3 wo) {
  dvec3 result(0);
  ((type.shader == &Shaders::info ? (result = Shaders::reference(v, wi, wo), 0) : 0), ...);
  return result;
}

dvec3 jitter(dvec3 v, double size, Random& random) {
  for (size_t c = 0; c < 3; ++c) v[c] += size * (2.0 * random.uniform() - 1.0);
  return v;
}

/// Where light comes from and how much of it, the cone aside.
struct Arrival {
  dvec3 wi;
  double irradiance = 1;  ///< without the window of a range
  double distance = 0;
};

Arrival arrive(const Light& light, dvec3 p, double scene_radius) {
  if (light.type == LightType::directional) return {-glm::normalize(dvec3(light.direction))};
  const dvec3 d = dvec3(light.position) - p;
  const double distance = std::max({glm::length(d), min_light_distance * scene_radius, 1e-18});
  return {d / distance, light.falloff ? 1 / (distance * distance) : 1, distance};
}

dvec3 direction_to_eye(dvec3 eye, dvec3 p) {
  const double distance = glm::distance(eye, p);
  return distance > 0 ? (eye - p) / distance : dvec3(0);
}

/// Part of the response, its window aside, that rounding of the distance may change: by a few
/// float digits, or from `d` to `d_off`.
double range_error(const Light& light, double d, double d_off) {
  const auto part = [&](double x) { return std::pow(x / reach_of(light), 4); };
  if (std::min(part(d), part(d_off)) > 1.001) return 0;
  return 2 * std::abs(part(d) - part(d_off)) + 2e-6 * part(d);
}

/// Part of the response that the rounding of a spot's cosine may change.
double cone_error(const Light& light, dvec3 wi, double wi_error) {
  if (light.type != LightType::spot) return 0;
  const double cos_outer = std::cos(light.outer_angle_deg * degree);
  const double range = std::cos(light.inner_angle_deg * degree) - cos_outer;
  if (range >= 1e-5) return std::min(1.0, 1.5 * (5e-7 + wi_error) / range);
  // A cone without a fade is a step: a record within rounding of its edge may be on either side.
  const double cosine = glm::dot(wi, -glm::normalize(dvec3(light.direction)));
  return std::abs(cosine - cos_outer) < 3e-6 + wi_error ? 1 : 0;
}

}  // namespace

ResponseBound bound_response(const SampleType& type, const float* vector, const Light& light,
                             dvec3 eye, double scene_radius, double position_error, int jitters) {
  const dvec3 exact = reference_response(type, vector, light, eye, scene_radius);
  const std::vector<double> v(vector, vector + type.width);
  const dvec3 p(v[0], v[1], v[2]);
  const Arrival arrival = arrive(light, p, scene_radius);
  const dvec3 base =
      shade_directly(AllShaders{}, type, v.data(), arrival.wi, direction_to_eye(eye, p));
  Random random(9, RandomStream::tests, 0);
  dvec3 spread(0);
  double wi_error = 0;
  double irradiance = arrival.irradiance;
  double window_error = 0;
  for (int i = 0; i < jitters; ++i) {
    const dvec3 p_off = jitter(p, position_error, random);
    const Arrival moved = arrive(light, p_off, scene_radius);
    const dvec3 wi = jitter(moved.wi, 4e-7, random);
    const dvec3 wo = jitter(direction_to_eye(eye, p_off), 4e-7, random);
    const dvec3 off = shade_directly(AllShaders{}, type, v.data(), wi, wo);
    spread = glm::max(spread, glm::abs(off - base));
    wi_error = std::max(wi_error, glm::distance(moved.wi, arrival.wi));
    irradiance = std::max(irradiance, moved.irradiance);
    window_error = std::max(window_error, range_error(light, arrival.distance, moved.distance));
  }
  const double relative =
      1e-5 + (type.width == 14 ? 3e-7 * v[13] : 0.0) + 4 * (irradiance / arrival.irradiance - 1);
  return {exact, relative * exact +
                     irradiance * (4.0 * spread +
                                   (base + spread) * (window_error + cone_error(light, arrival.wi,
                                                                                4 * wi_error))) +
                     dvec3(1e-15 * irradiance)};
}

}  // namespace relume::test

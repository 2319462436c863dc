#include "core/scene/light.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/random.h"

namespace relume {
namespace {

void require(bool ok, const std::string& place, const char* field, const char* what,
             const char* mend) {
  if (!ok) throw input_error(place + "/" + field, what, mend);
}

float between(float low, float high, Random& random) {
  return low + (high - low) * random.uniform();
}

vec3 between(vec3 low, vec3 high, Random& random) {
  const float x = between(low.x, high.x, random);
  const float y = between(low.y, high.y, random);
  const float z = between(low.z, high.z, random);
  return {x, y, z};
}

}  // namespace

float reach_of(const Light& light) {
  const bool ends = light.type != LightType::directional && light.falloff && light.range > 0;
  return ends ? light.range : std::numeric_limits<float>::infinity();
}

void validate_light(const Light& light, const std::string& place) {
  // Squared distances must stay within a float.
  require(is_finite(light.position) && max_abs_component(light.position) <= 1e15f, place,
          "position", "is not finite or above 1e15",
          "give three numbers; for a light that far, a directional one");
  require(is_finite(light.direction) && glm::length(dvec3(light.direction)) > 0, place, "direction",
          "is zero or not finite", "give three numbers, not all zero");
  require(light.outer_angle_deg >= min_spot_angle_deg && light.outer_angle_deg <= 90, place,
          "outer_angle_deg", "is not within [0.5, 90]", "give the half angle in degrees");
  require(light.inner_angle_deg >= 0 && light.inner_angle_deg <= light.outer_angle_deg, place,
          "inner_angle_deg", "is not within [0, outer_angle_deg]",
          "give the half angle in degrees");
  require(light.range == 0 || (light.range >= 1e-15f && light.range <= 1e15f), place, "range",
          "is not 0 or within [1e-15, 1e15]",
          "give the distance where the light ends, or 0 for none");
  require(is_finite(light.color) && glm::all(glm::greaterThanEqual(light.color, vec3(0))) &&
              max_component(light.color) <= 1e20f,
          place, "color", "has a component that is negative, not finite or above 1e20",
          "give three scene-linear values");
  require(light.gain >= 0 && light.gain <= 1e20f, place, "gain",
          "is negative, not finite or above 1e20", "give a number >= 0");
}

bool same_layer(const Light& a, const Light& b) {
  if (a.type != b.type || a.casts_shadow != b.casts_shadow) return false;
  const bool same_position =
      a.position == b.position && a.falloff == b.falloff && reach_of(a) == reach_of(b);
  const bool same_direction = a.direction == b.direction;
  switch (a.type) {
    case LightType::point:
      return same_position;
    case LightType::directional:
      return same_direction;
    case LightType::spot:
      return same_position && same_direction && a.inner_angle_deg == b.inner_angle_deg &&
             a.outer_angle_deg == b.outer_angle_deg;
  }
  return false;
}

bool can_interpolate(const Light& a, const Light& b) {
  return a.type == b.type && a.falloff == b.falloff && a.casts_shadow == b.casts_shadow &&
         (a.range > 0) == (b.range > 0);
}

Light interpolate_light(const Light& low, const Light& high, uint64_t seed, uint64_t index) {
  Random random(seed, RandomStream::lights, index);
  Light light = low;
  light.name = fmt::format("{}-{}", low.name, index);
  light.position = between(low.position, high.position, random);
  light.direction = between(low.direction, high.direction, random);
  light.inner_angle_deg = between(low.inner_angle_deg, high.inner_angle_deg, random);
  light.outer_angle_deg = between(low.outer_angle_deg, high.outer_angle_deg, random);
  light.inner_angle_deg = std::min(light.inner_angle_deg, light.outer_angle_deg);
  light.color = between(low.color, high.color, random);
  light.gain = between(low.gain, high.gain, random);
  light.range = between(low.range, high.range, random);
  if (!(glm::length(light.direction) > 0)) light.direction = low.direction;
  return light;
}

}  // namespace relume

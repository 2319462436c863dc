#include "core/scene/light_animation.h"

#include <cmath>

#include "core/base/check.h"

namespace relume {
namespace {

/// `v` turned about the unit `axis` through the origin (Rodrigues).
vec3 turn(vec3 v, vec3 axis, double angle) {
  const auto cosine = static_cast<float>(std::cos(angle));
  const auto sine = static_cast<float>(std::sin(angle));
  return v * cosine + glm::cross(axis, v) * sine + axis * (glm::dot(axis, v) * (1 - cosine));
}

template <class Value>
void apply(const Keyframes<Value>& keyframes, float frame, Value& value) {
  if (!keyframes.empty()) value = value_at(keyframes, frame);
}

void apply(const Turntable& turntable, float frame, Light& light) {
  constexpr double radians_per_degree = 3.14159265358979323846 / 180;
  const double turns = (double{frame} - turntable.first) / (turntable.last - turntable.first);
  const double degrees = std::fmod(turntable.degrees * turns, 360);
  // A whole turn ends exactly where it began.
  if (degrees == 0) return;
  const double angle = degrees * radians_per_degree;
  light.position =
      turntable.center + turn(light.position - turntable.center, turntable.axis, angle);
  light.direction = turn(light.direction, turntable.axis, angle);
}

}  // namespace

bool LightAnimation::is_set() const {
  return !position.empty() || !direction.empty() || !target.empty() || !color.empty() ||
         !gain.empty() || !inner_angle_deg.empty() || !outer_angle_deg.empty() || !range.empty() ||
         turntable.has_value();
}

Light light_at(const Light& light, const LightAnimation& animation, float frame) {
  if (!animation.is_set()) return light;
  Light result = light;
  apply(animation.position, frame, result.position);
  apply(animation.direction, frame, result.direction);
  apply(animation.color, frame, result.color);
  apply(animation.gain, frame, result.gain);
  apply(animation.outer_angle_deg, frame, result.outer_angle_deg);
  apply(animation.inner_angle_deg, frame, result.inner_angle_deg);
  apply(animation.range, frame, result.range);
  result.inner_angle_deg = std::min(result.inner_angle_deg, result.outer_angle_deg);
  if (animation.turntable) apply(*animation.turntable, frame, result);
  if (!animation.target.empty()) {
    result.direction = value_at(animation.target, frame) - result.position;
  } else if (animation.keeps_target && result.position != light.position) {
    result.direction = light.position + light.direction - result.position;
  }
  return result;
}

std::vector<Light> lights_at(std::span<const Light> lights,
                             std::span<const LightAnimation> animations, float frame) {
  CHECK_MSG(lights.size() == animations.size(), "{} lights, {} animations", lights.size(),
            animations.size());
  std::vector<Light> result;
  for (size_t i = 0; i < lights.size(); ++i) {
    result.push_back(light_at(lights[i], animations[i], frame));
  }
  return result;
}

}  // namespace relume

#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/scene/light.h"

namespace relume {

/// The values of a parameter at frames, which ascend strictly. Empty: it is not animated.
template <class Value>
using Keyframes = std::vector<std::pair<float, Value>>;

/// A turn about an axis at constant speed: `degrees` between the frames `first` and `last`, going
/// on before and after them. Counter-clockwise where the axis points at the viewer.
struct Turntable {
  vec3 center{0};      ///< world
  vec3 axis{0, 1, 0};  ///< unit
  float first = 0;     ///< frame at which the light is where it would be without
  float last = 1;      ///< > first
  float degrees = 360;
};

/// What changes of a light from frame to frame; its other values stay.
struct LightAnimation {
  Keyframes<vec3> position;   ///< world
  Keyframes<vec3> direction;  ///< interpolated component by component
  Keyframes<vec3> target;     ///< world; the light is aimed at it from wherever it is
  Keyframes<vec3> color;
  Keyframes<float> gain;
  Keyframes<float> inner_angle_deg;
  Keyframes<float> outer_angle_deg;
  Keyframes<float> range;
  std::optional<Turntable> turntable;  ///< turns position and direction, after the keyframes
  bool keeps_target = false;           ///< aimed at position + direction of the light at rest

  bool is_set() const;
};

/// Linear between keyframes, the first value before them and the last one after. Not empty.
template <class Value>
Value value_at(const Keyframes<Value>& keyframes, float frame) {
  if (frame <= keyframes.front().first) return keyframes.front().second;
  for (size_t i = 1; i < keyframes.size(); ++i) {
    const auto& [end, high] = keyframes[i];
    if (frame >= end) continue;
    const auto& [start, low] = keyframes[i - 1];
    const float part = (frame - start) / (end - start);
    return low + (high - low) * part;
  }
  return keyframes.back().second;
}

/// The light at a frame. May be invalid where interpolation makes it so: a direction that passes
/// through zero; see validate_light().
Light light_at(const Light& light, const LightAnimation& animation, float frame);

/// All of them; `animations` are parallel to `lights`.
std::vector<Light> lights_at(std::span<const Light> lights,
                             std::span<const LightAnimation> animations, float frame);

}  // namespace relume

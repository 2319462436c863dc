#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "core/base/label.h"
#include "core/math/vec.h"

namespace relume {

enum class LightType { point, spot, directional };

inline constexpr std::array light_type_labels = {
    Label<LightType>{LightType::point, "point"},
    Label<LightType>{LightType::spot, "spot"},
    Label<LightType>{LightType::directional, "directional"},
};

/// Cones below half a degree are not resolved by single-precision cosines.
inline constexpr float min_spot_angle_deg = 0.5f;

/// One light. Geometry (type, position, direction, cone, falloff, range) decides a light's layer;
/// gain, colour and mute only weigh it, so changing them never reshades (sec. "Lights" of the
/// design).
struct Light {
  std::string name = "light";
  LightType type = LightType::point;
  vec3 position{0, 0, 0};  ///< world; point and spot
  vec3 direction{0, -1,
                 0};  ///< world, the way the light travels, any length > 0; spot, directional
  float inner_angle_deg = 20;  ///< spot: half angle of the full-intensity cone, [0, outer]
  /// Spot: half angle where it reaches zero, [min_spot_angle_deg, 90].
  float outer_angle_deg = 30;
  /// Inverse-square falloff: irradiance = color * gain / d^2. Off: irradiance = color * gain at any
  /// distance. Directional lights have none.
  bool falloff = true;
  /// World units: with falloff, irradiance is windowed by max(0, 1 - (d / range)^4), so that the
  /// light ends there (glTF, KHR_lights_punctual). 0: it has no end.
  float range = 0;
  vec3 color{1, 1, 1};  ///< scene-linear, >= 0
  float gain = 1;  ///< radiant intensity (falloff on) or irradiance (off) per unit colour, >= 0
  bool mute = false;
  bool casts_shadow = true;

  /// The weight of the light's layer: color * gain, or 0 when muted. At most the largest float, so
  /// that a light too bright for a float leaves black what it does not reach.
  vec3 weight() const {
    return mute ? vec3(0) : glm::min(color * gain, vec3(std::numeric_limits<float>::max()));
  }
};

/// The distance beyond which a light gives nothing, world units; infinite where it has no end.
float reach_of(const Light& light);

/// Throws Error(input) that names `place` and the field when a parameter is not finite or out of
/// range.
void validate_light(const Light& light, const std::string& place);

/// True when two lights shade the same layer, that is differ in weight or name only.
bool same_layer(const Light& a, const Light& b);

/// True when two lights agree in all but numbers, as interpolate_light() requires.
bool can_interpolate(const Light& a, const Light& b);

/// A random light between two representatives (TR2007-600 sec. 3.2): position, direction, angles,
/// colour and gain are interpolated independently of each other, each vector component by itself,
/// so the two bound a box. Deterministic in (seed, index).
Light interpolate_light(const Light& low, const Light& high, uint64_t seed, uint64_t index);

}  // namespace relume

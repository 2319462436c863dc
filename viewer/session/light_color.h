#pragma once

#include <optional>

#include "core/math/vec.h"

namespace relume {

inline constexpr float min_temperature_k = 1000;
inline constexpr float max_temperature_k = 15000;

/// The colour of a black body at `kelvin` (clamped to the range above), scene-linear Rec. 709, with
/// the luminance of `like`. Chromaticity after Krystek 1985, who states 9e-5 in u, v; what lies
/// outside of the colour space, below 1900 K, is clipped to it.
vec3 color_of_temperature(float kelvin, vec3 like);

/// The temperature whose colour is nearest to `color` (CIE 1960 u, v); nothing for black, and for
/// colours that are far from any: more than 0.06 away.
std::optional<float> temperature_of_color(vec3 color);

}  // namespace relume

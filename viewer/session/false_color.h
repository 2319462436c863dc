#pragma once

#include <span>

#include "core/image/image.h"

namespace relume {

inline constexpr float false_color_low = -6;  ///< stops below middle grey, where the scale starts
inline constexpr float false_color_high = 6;  ///< stops above it, where the scale ends
inline constexpr float middle_grey = 0.18f;   ///< scene-linear

/// The colour for a luminance `stops` above middle grey, one for each stop; sRGB-encoded. Middle
/// grey is grey, what is darker is blue to violet, brighter green to red; what lies beyond the
/// scale is black or white.
vec3 false_color(float stops);

/// Shows each pixel's luminance, times 2^exposure, as false_color(): RGBA, alpha 255, into a buffer
/// of 4 * pixels bytes.
void apply_false_color(const Image& image, float exposure, std::span<uint8_t> rgba);

}  // namespace relume

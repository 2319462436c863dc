#pragma once

#include "core/base/label.h"
#include "core/image/image.h"

namespace relume {

enum class ToneCurve { srgb, filmic };

inline constexpr std::array tone_curve_labels = {
    Label<ToneCurve>{ToneCurve::srgb, "srgb"},
    Label<ToneCurve>{ToneCurve::filmic, "filmic"},
};

/// From scene-linear to the display. srgb clips at 1; filmic rolls highlights off (fit of the ACES
/// reference curve by Narkowicz 2015).
struct DisplayTransform {
  float exposure = 0;  ///< stops: multiplies by 2^exposure first
  ToneCurve curve = ToneCurve::srgb;
};

/// `image` (first three channels) as 8-bit RGB, within 0.6 code values of the exact curve. Negative
/// values and NaN give 0, infinity 255. Parallel; deterministic.
DisplayImage apply_display(const Image& image, const DisplayTransform& transform);

/// The same as RGBA with alpha 255, into a caller's buffer of 4 * pixels bytes; no allocation.
void apply_display_rgba(const Image& image, const DisplayTransform& transform,
                        std::span<uint8_t> rgba);

}  // namespace relume

#pragma once

#include "core/base/label.h"
#include "core/image/image.h"

namespace relume {

/// From scene-linear to the display. srgb clips at 1; filmic rolls highlights off (fit of the ACES
/// reference curve by Narkowicz 2015); config is the view of $OCIO, see color_config.h.
enum class ToneCurve { srgb, filmic, config };

inline constexpr std::array tone_curve_labels = {
    Label<ToneCurve>{ToneCurve::srgb, "srgb"},
    Label<ToneCurve>{ToneCurve::filmic, "filmic"},
    Label<ToneCurve>{ToneCurve::config, "config"},
};

/// What shows pictures unless a person chooses: config where $OCIO names a configuration, else
/// srgb.
ToneCurve default_curve();

/// How exact the curve config is: `draft` reads it from a ViewTable.
enum class DisplayQuality { draft, exact };

struct DisplayTransform {
  float exposure = 0;  ///< stops: multiplies by 2^exposure first
  ToneCurve curve = ToneCurve::srgb;
};

/// `image` (first three channels) as 8-bit RGB: srgb and filmic within 0.6 code values of the exact
/// curve, config as quantize_display() of apply_config_view(). Negative values and NaN give 0,
/// infinity 255; with config what the configuration makes of them. Parallel; deterministic. Throws
/// Error(input) where config cannot be had.
DisplayImage apply_display(const Image& image, const DisplayTransform& transform);

/// The same as RGBA with alpha 255, into a caller's buffer of 4 * pixels bytes; no allocation.
void apply_display_rgba(const Image& image, const DisplayTransform& transform,
                        std::span<uint8_t> rgba, DisplayQuality quality = DisplayQuality::exact);

}  // namespace relume

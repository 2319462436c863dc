#pragma once

#include "core/image/image.h"

namespace relume {

/// The perceptually uniform "inferno" map (Smith and van der Walt, matplotlib, CC0), by cubic
/// interpolation of 17 knots: 0 -> black, 1 -> light yellow, luminance ascending, sRGB-encoded in
/// [0,1]. Clamps; NaN gives magenta.
vec3 heat_color(float value);

struct HeatmapParams {
  /// The value that maps to the top of the scale. 0: automatic, the 99.5 % quantile of the non-zero
  /// errors rounded up to 1, 2 or 5 times a power of ten.
  float range = 0;
  bool scale_bar = true;  ///< append a labelled bar below the picture
};

/// The range that HeatmapParams::range = 0 picks for a one-channel error image (>= 1e-9).
float automatic_range(const Image& error);

/// A one-channel error image in false colour, with a scale bar in the unit of the values.
DisplayImage render_heatmap(const Image& error, const HeatmapParams& params);

}  // namespace relume

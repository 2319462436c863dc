#include "viewer/session/picture_histogram.h"

#include <algorithm>

namespace relume {

PictureHistogram make_histogram(std::span<const uint8_t> rgba) {
  PictureHistogram histogram;
  size_t clipped = 0;
  size_t black = 0;
  for (size_t i = 0; i + 4 <= rgba.size(); i += 4) {
    for (size_t c = 0; c < 3; ++c) ++histogram.counts[c][rgba[i + c]];
    clipped += std::max({rgba[i], rgba[i + 1], rgba[i + 2]}) == 255 ? 1 : 0;
    black += (rgba[i] | rgba[i + 1] | rgba[i + 2]) == 0 ? 1 : 0;
  }
  for (const auto& counts : histogram.counts) {
    histogram.largest =
        std::max(histogram.largest, *std::max_element(counts.begin() + 1, counts.end() - 1));
  }
  const double pixels = static_cast<double>(rgba.size() / 4);
  if (pixels > 0) {
    histogram.clipped_share = static_cast<double>(clipped) / pixels;
    histogram.black_share = static_cast<double>(black) / pixels;
  }
  return histogram;
}

}  // namespace relume

#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace relume {

/// How often each value of a display picture occurs, by channel.
struct PictureHistogram {
  std::array<std::array<uint32_t, 256>, 3> counts{};
  uint32_t largest = 0;      ///< count, black and white aside, which often dwarf the others
  double clipped_share = 0;  ///< of the pixels: some channel is 255
  double black_share = 0;    ///< of the pixels: all channels are 0
};

/// Of RGBA pixels.
PictureHistogram make_histogram(std::span<const uint8_t> rgba);

}  // namespace relume

#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/math/vec.h"

namespace relume {

/// A float image, scene-linear unless said otherwise: `channels` interleaved floats a pixel, rows
/// top to bottom.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<float> pixels;

  Image() = default;
  Image(int width_px, int height_px, int channel_count = 3)
      : width(width_px),
        height(height_px),
        channels(channel_count),
        pixels(static_cast<size_t>(width_px) * height_px * channel_count) {}

  size_t pixel_count() const { return static_cast<size_t>(width) * height; }
  float* at(int x, int y) { return &pixels[(static_cast<size_t>(y) * width + x) * channels]; }
  const float* at(int x, int y) const {
    return &pixels[(static_cast<size_t>(y) * width + x) * channels];
  }
  /// The first three channels of a pixel.
  vec3 rgb(size_t pixel) const {
    const float* p = &pixels[pixel * channels];
    return {p[0], p[1], p[2]};
  }
};

/// An image of one channel from width * height values, row-major.
inline Image make_map(int width, int height, std::vector<float> values) {
  Image image;
  image.width = width;
  image.height = height;
  image.channels = 1;
  image.pixels = std::move(values);
  return image;
}

/// An 8-bit display image, sRGB-encoded, RGB or RGBA interleaved, rows top to bottom.
struct DisplayImage {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<uint8_t> pixels;
};

}  // namespace relume

#pragma once

#include <atomic>
#include <cstdint>

#include "core/image/image.h"

namespace relume {

/// The only writer of rendered pixels: a value that is not finite is replaced by 0 and counted.
/// Different pixels may be written by different threads at once.
class Film {
 public:
  /// Writes into `image`, which must outlive the film and have three channels.
  explicit Film(Image& image) : image_(image) {}

  void write(int x, int y, vec3 rgb);
  /// Writes `count` neighbouring pixels of a row, from pixel (x, y) on, three floats each.
  void write_row(int x, int y, int count, const float* rgb);
  /// The same from four floats a pixel, of which the fourth is not used but finite.
  void write_row_rgbx(int x, int y, int count, const float* rgbx);
  /// Values replaced so far.
  uint64_t replaced() const { return replaced_.load(std::memory_order_relaxed); }

 private:
  Image& image_;
  std::atomic<uint64_t> replaced_{0};
};

}  // namespace relume

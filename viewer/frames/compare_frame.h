#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "viewer/frames/frame_layers.h"

namespace relume {

/// Where a frame's file is not what it should be, bit for bit.
struct FrameDifference {
  std::string channel;  ///< of the first value that differs, row by row, pixel by pixel
  int x = 0;            ///< pixels
  int y = 0;
  float found = 0;  ///< in the file
  float expected = 0;
  uint64_t values = 0;  ///< how many differ
  double largest = 0;   ///< absolute difference; infinite where one is not finite
};

/// Compares a file with layers of the same picture; nothing when all values have the same bits.
/// Throws Error(input) where size or channels are not those of `layers`.
std::optional<FrameDifference> compare_frame(const std::filesystem::path& path,
                                             const FrameLayers& expected);

}  // namespace relume

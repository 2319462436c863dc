#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace relume {

/// A channel of a deep image.
struct DeepChannel {
  std::string name;
  bool is_half = true;  ///< stored as 16-bit float, else as 32-bit
};

/// A picture with any number of samples a pixel.
struct DeepImage {
  int width = 0;  ///< pixels
  int height = 0;
  std::vector<DeepChannel> channels;
  std::vector<uint32_t> counts;  ///< samples of each pixel, row by row
  std::vector<float> values;     ///< pixel by pixel, sample by sample: one of each channel

  size_t pixel_count() const { return static_cast<size_t>(width) * height; }
};

/// Writes a deep scanline EXR, zips-compressed, atomically; equal calls write equal bytes.
/// `metadata` become string attributes. Throws Error(output).
void write_deep_exr(const std::filesystem::path& path, const DeepImage& image,
                    const std::vector<std::pair<std::string, std::string>>& metadata = {});

/// Channel names of a deep image and its size. Throws Error(input) or Error(limit).
DeepImage read_deep_header(const std::filesystem::path& path);

/// Reads these channels, in this order, of the display window; values as stored, integers as
/// numbers. Throws Error(input) for a broken file or a missing channel, Error(limit) where the
/// samples would take more than 8 GiB, row by row before they are copied.
DeepImage read_deep_image(const std::filesystem::path& path, std::span<const std::string> names);

}  // namespace relume

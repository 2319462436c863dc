#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/image/image.h"

namespace relume {

/// One group of channels of an EXR. The channels are `prefix` + names[i]: {"light.key.",
/// {"R","G","B"}}.
struct ExrLayer {
  std::string prefix;
  std::vector<std::string> names;
  const Image* image;  ///< names.size() channels, all layers of equal size
};

/// Writes a scene-linear, 32-bit float, zip-compressed EXR atomically (temporary, fsync, rename).
/// `metadata` become string attributes; no date is written, so that equal calls write equal bytes.
/// Throws Error(output).
void write_exr(const std::filesystem::path& path, std::span<const ExrLayer> layers,
               const std::vector<std::pair<std::string, std::string>>& metadata = {});

/// Writes an 8-bit PNG atomically. Throws Error(output).
void write_png(const std::filesystem::path& path, const DisplayImage& image);

/// Reads R, G, B (by name; else the first three channels; grey is repeated) of an EXR or any other
/// image; 8-bit files are decoded from sRGB to linear. Throws Error(input), or Error(limit) above
/// 16384 x 16384. Non-finite values are an Error(input) that names the first such pixel.
Image read_image(const std::filesystem::path& path);

/// Reads the channels whose names start with `prefix` ("light.key."), in R, G, B order.
Image read_exr_layer(const std::filesystem::path& path, const std::string& prefix);

/// One channel by its full name, as an image of one channel.
Image read_exr_channel(const std::filesystem::path& path, const std::string& name);

/// The channel names of an image file, in file order.
std::vector<std::string> read_channel_names(const std::filesystem::path& path);

/// What an image file says about itself.
struct ImageHeader {
  int width = 0;  ///< pixels of the display window
  int height = 0;
  std::vector<std::string> channels;                          ///< in file order
  std::vector<std::pair<std::string, std::string>> metadata;  ///< attributes that are strings
};

/// Reads no pixel. Throws as read_image does.
ImageHeader read_image_header(const std::filesystem::path& path);

/// Reads channels by their full names, as stored, non-finite values included: row(y, values) gets
/// width * names.size() interleaved values for each row of the display window from top to bottom,
/// 0 outside the data. Takes memory for some rows only. Throws as read_image does.
void read_channel_rows(const std::filesystem::path& path, std::span<const std::string> names,
                       const std::function<void(int y, std::span<const float> values)>& row);

}  // namespace relume

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace relume {

/// Largest side of an image, pixels.
constexpr int max_image_px = 16384;
constexpr int max_image_channels = 1024;

/// A library's message on one line.
std::string one_line(std::string text);

/// An image's file and who asks for it, for messages: "FILE" or "PLACE: image 'FILE'".
struct ImageSource {
  std::filesystem::path path;
  std::string place;
  std::span<const std::byte> bytes = {};  ///< the file's, where it lies in another one

  Error broken(std::string_view what, std::string_view mend) const {
    return input_error(place, what, mend);
  }
  Error unreadable(const std::string& reason) const;
};

/// What a flat image says about itself.
struct ImageSpec {
  int width = 0;  ///< pixels of the data window
  int height = 0;
  int x = 0;  ///< the data window's first pixel
  int y = 0;
  int full_width = 0;  ///< pixels of the display window
  int full_height = 0;
  int full_x = 0;  ///< the display window's first pixel
  int full_y = 0;
  int alpha_channel = -1;  ///< index of a channel, -1: none
  bool is_bytes = false;   ///< stored with 8 bits a value
  bool is_srgb = false;    ///< integers that are display-encoded; those of 8 bits always are
  std::vector<std::string> channels;                          ///< names, in file order
  std::vector<std::pair<std::string, std::string>> metadata;  ///< attributes that are strings

  size_t row_values() const { return static_cast<size_t>(width) * channels.size(); }
  int channel_index(std::string_view name) const;  ///< -1: none of that name
};

/// A flat image that is open: its header has been checked, no pixel has been read.
class ImageInput {
 public:
  virtual ~ImageInput() = default;

  const ImageSpec& spec() const { return spec_; }
  /// Calls row(y, values) for each row of the data window, from the top (0) on, with all channels
  /// interleaved; integers become 0 to 1. Once only. Throws Error(input) where the file ends early
  /// or is corrupt.
  virtual void read_rows(const std::function<void(int y, const float* values)>& row) = 0;
  /// The same for a file of 8 bits a value, as stored.
  virtual void read_rows(const std::function<void(int y, const uint8_t* values)>& row) = 0;

 protected:
  ImageSpec spec_;
};

/// Opens an image by what its first bytes say that it is, whatever it is called; Targa, which has
/// no such bytes, by its name. EXR, PNG and JPEG are decoded here, after their headers were walked;
/// TIFF, BMP, Radiance HDR and Targa in another process (core/image/decoder_process.h). Throws
/// Error(input), or Error(limit) above max_image_px or max_image_channels.
std::unique_ptr<ImageInput> open_image(const ImageSource& source);

/// The same in this process whatever the format: for the decoder's own process.
std::unique_ptr<ImageInput> open_image_here(const ImageSource& source);

}  // namespace relume

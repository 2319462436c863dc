#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/math/vec.h"

namespace relume {

/// Rows of chosen channels.
struct ExrRowValues {
  std::vector<uint32_t> counts;  ///< deep: samples of each pixel, row by row; flat: empty
  std::vector<float> values;     ///< pixel by pixel, sample by sample: one of each chosen channel
};

/// A rectangle of pixels, empty where a side of `high` is not above that of `low`.
struct PixelRange {
  ivec2 low{0};
  ivec2 high{0};
};

/// An open EXR, flat or of deep scanlines, whose rows are read as they are needed, in any order.
/// One thread at a time.
class ExrRows {
 public:
  /// Reads no pixel. Throws Error(input) for what is no EXR, is broken, or is deep and tiled;
  /// Error(limit) above 65536 pixels a side (deep: 16384) or 1024 channels.
  explicit ExrRows(const std::filesystem::path& path);
  ~ExrRows();
  ExrRows(ExrRows&&) noexcept;
  ExrRows& operator=(ExrRows&&) noexcept;

  int width() const;  ///< pixels of the display window
  int height() const;
  /// Pixels of the display window that the file holds: from `low` on, before `high`.
  PixelRange data_window() const;
  bool is_deep() const;
  /// In file order.
  std::vector<std::string> channels() const;
  bool is_half(const std::string& channel) const;

  /// Which channels read() gives, in this order. Throws Error(input) for one that is missing.
  void choose(std::span<const std::string> names);

  /// Rows [begin, end) of the display window, as stored, non-finite values included; integers of
  /// deep images as numbers. Outside the data 0, or no samples. Takes memory for these rows and a
  /// band of the file's. Throws Error(input) where the file is broken, Error(limit) where deep
  /// samples of these rows would take more than 8 GiB, before they are copied.
  ExrRowValues read(int begin, int end);

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace relume

#pragma once

#include <filesystem>
#include <string>

namespace relume {

/// Frames first, first + 1, ... last.
struct FrameRange {
  int first = 0;  ///< >= 0
  int last = 0;   ///< >= first

  int count() const { return last - first + 1; }
};

/// "1-24" or "7". Throws Error(usage).
FrameRange parse_frame_range(const std::string& text);

/// The name of a frame's file: the run of '#' in the pattern's file name becomes the frame, with at
/// least as many digits. Throws Error(usage) where there is no single such run.
std::filesystem::path frame_path(const std::filesystem::path& pattern, int frame);

}  // namespace relume

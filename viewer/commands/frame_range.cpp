#include "viewer/commands/frame_range.h"

#include <fmt/format.h>

#include <cstdio>

#include "core/base/error.h"

namespace relume {

FrameRange parse_frame_range(const std::string& text) {
  constexpr int max_frame = 1000000;
  FrameRange range;
  char rest = 0;
  int found = std::sscanf(text.c_str(), "%d-%d%c", &range.first, &range.last, &rest);
  if (found == 1 && text.find('-', 1) == std::string::npos) {
    range.last = range.first;
    found = std::sscanf(text.c_str(), "%d%c", &range.first, &rest) + 1;
  }
  if (found != 2 || range.first < 0 || range.last < range.first || range.last > max_frame) {
    throw Error(ErrorKind::usage,
                fmt::format("--frames: '{}' is no range; give FIRST-LAST, 0 to {}", printable(text),
                            max_frame));
  }
  return range;
}

std::filesystem::path frame_path(const std::filesystem::path& pattern, int frame) {
  const std::string name = pattern.filename().string();
  const size_t first = name.find('#');
  const size_t end = std::min(name.find_first_not_of('#', first), name.size());
  if (first == std::string::npos || name.find('#', end) != std::string::npos) {
    throw Error(ErrorKind::usage, pattern.string() +
                                      ": --frames needs one run of '#' where the frame stands, as "
                                      "in frame.####.exr");
  }
  return pattern.parent_path() /
         fmt::format("{}{:0{}d}{}", name.substr(0, first), frame, end - first, name.substr(end));
}

}  // namespace relume

#include "core/image/jpeg_segments.h"

#include <algorithm>

namespace relume {
namespace {

constexpr std::byte mark{0xff};

// The byte after the mark.
constexpr int first_restart = 0xd0;
constexpr int end_of_image = 0xd9;
constexpr int start_of_scan = 0xda;
constexpr int application = 0xe0;  ///< and the 15 above
constexpr int adobe = 0xee;
constexpr int comment = 0xfe;

bool has_no_length(int marker) {
  return marker == 1 || (marker >= first_restart && marker <= end_of_image);
}

bool is_picture(int marker) {
  if (marker == application || marker == adobe) return true;
  return !(marker > application && marker < application + 16) && marker != comment;
}

/// The next marker at or after `at`, which then lies behind it; 0 at the file's end.
int next_marker(std::span<const std::byte> file, size_t& at) {
  while (true) {
    while (at < file.size() && file[at] != mark) ++at;
    while (at < file.size() && file[at] == mark) ++at;
    if (at >= file.size()) return 0;
    if (const int marker = std::to_integer<int>(file[at++]); marker != 0) return marker;
  }
}

}  // namespace

std::vector<std::byte> jpeg_without_metadata(std::span<const std::byte> file) {
  std::vector<std::byte> out;
  out.reserve(file.size());
  const auto append = [&](size_t begin, size_t end) {
    out.insert(out.end(), file.begin() + static_cast<std::ptrdiff_t>(begin),
               file.begin() + static_cast<std::ptrdiff_t>(end));
  };
  size_t at = 0;
  while (const int marker = next_marker(file, at)) {
    const size_t body = at;
    if (marker == start_of_scan || marker == end_of_image) {
      out.insert(out.end(), {mark, static_cast<std::byte>(marker)});
      append(body, file.size());
      break;
    }
    if (has_no_length(marker)) {
      out.insert(out.end(), {mark, static_cast<std::byte>(marker)});
      continue;
    }
    if (file.size() - at < 2) break;
    const size_t length =
        std::to_integer<size_t>(file[at]) << 8 | std::to_integer<size_t>(file[at + 1]);
    if (length < 2 || length > file.size() - at) break;
    at += length;
    if (!is_picture(marker)) continue;
    out.insert(out.end(), {mark, static_cast<std::byte>(marker)});
    append(body, at);
  }
  return out;
}

}  // namespace relume

#include "core/image/jpeg_segments.h"

#include <algorithm>

namespace relume {
namespace {

constexpr std::byte mark{0xff};

// The byte after the mark.
constexpr int first_frame = 0xc0;
constexpr int last_frame = 0xcf;
constexpr int huffman_tables = 0xc4;
constexpr int arithmetic_conditions = 0xcc;
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

bool is_frame(int marker) {
  return marker >= first_frame && marker <= last_frame && marker != huffman_tables &&
         marker != arithmetic_conditions;
}

/// Of two bytes, the higher one first.
int number(std::span<const std::byte> bytes, size_t at) {
  return std::to_integer<int>(bytes[at]) << 8 | std::to_integer<int>(bytes[at + 1]);
}

/// From a frame's header: its length, the precision, height, width and channels.
void note_size(std::span<const std::byte> header, JpegPicture& picture) {
  if (header.size() < 8) return;
  picture.height = std::max(picture.height, number(header, 3));
  picture.width = std::max(picture.width, number(header, 5));
  picture.channels = std::max(picture.channels, std::to_integer<int>(header[7]));
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

JpegPicture jpeg_without_metadata(std::span<const std::byte> file) {
  JpegPicture picture;
  std::vector<std::byte>& out = picture.bytes;
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
    const auto length = static_cast<size_t>(number(file, at));
    if (length < 2 || length > file.size() - at) break;
    at += length;
    if (!is_picture(marker)) continue;
    out.insert(out.end(), {mark, static_cast<std::byte>(marker)});
    append(body, at);
    if (is_frame(marker)) note_size(file.subspan(body, length), picture);
  }
  return picture;
}

}  // namespace relume

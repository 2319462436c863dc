#include "core/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

namespace relume {
namespace {

std::string one_line(std::string_view place, std::string_view what, std::string_view mend) {
  return fmt::format("{}: {}; {}", printable(place, 400), printable(what, 400),
                     printable(mend, 400));
}

/// Bytes of the UTF-8 character that `text` starts with; 0 when it is a control character or no
/// valid UTF-8.
size_t character_length(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return first < 0x20 || first == 0x7f ? 0 : 1;
  const size_t length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || length > text.size()) return 0;
  uint32_t code = first & (0x7fu >> length);
  for (size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  const bool too_long = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool not_a_character = code > 0x10ffff || (code >= 0xd800 && code < 0xe000);
  const bool control = code < 0xa0 || code == 0x2028 || code == 0x2029;
  return too_long || not_a_character || control ? 0 : length;
}

}  // namespace

std::string printable(std::string_view text, size_t max_length) {
  std::string out;
  for (size_t i = 0; i < text.size();) {
    const size_t length = character_length(text.substr(i));
    if (i + std::max<size_t>(1, length) > max_length) return out + "...";
    if (length > 0) {
      out += text.substr(i, length);
    } else {
      out += '?';
    }
    i += std::max<size_t>(1, length);
  }
  return out;
}

Error input_error(std::string_view place, std::string_view what, std::string_view mend) {
  return Error(ErrorKind::input, one_line(place, what, mend));
}

Error limit_error(std::string_view place, std::string_view what, std::string_view mend) {
  return Error(ErrorKind::limit, one_line(place, what, mend));
}

Error output_error(std::string_view place, std::string_view what, std::string_view mend) {
  return Error(ErrorKind::output, one_line(place, what, mend));
}

}  // namespace relume

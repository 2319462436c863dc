#include "core/base/error.h"

#include <fmt/format.h>

namespace relume {
namespace {

std::string one_line(std::string_view place, std::string_view what, std::string_view mend) {
  return fmt::format("{}: {}; {}", printable(place, 400), printable(what, 400), printable(mend, 400));
}

}  // namespace

std::string printable(std::string_view text, size_t max_length) {
  std::string out(text.substr(0, max_length));
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  if (text.size() > max_length) out += "...";
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

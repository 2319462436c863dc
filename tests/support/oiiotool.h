#pragma once

#include <cstdlib>
#include <string>

namespace relume::test {

/// OpenImageIO's program, which writes images as others do; tests skip where it is missing.
inline bool has_oiiotool() {
  return std::system("command -v oiiotool >/dev/null") == 0;
}

/// Runs it with these arguments; false where it fails.
inline bool run_oiiotool(const std::string& arguments) {
  return std::system(("oiiotool " + arguments).c_str()) == 0;
}

}  // namespace relume::test

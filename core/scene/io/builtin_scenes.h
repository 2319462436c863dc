#pragma once

#include <span>
#include <string_view>

namespace relume {

struct BuiltinScene {
  std::string_view name;  ///< "hair"
  std::string_view text;  ///< the scene file's text
};

/// The scenes that the program carries: the files scenes/NAME.json, turned into C++ by CMake when
/// it configures (core/CMakeLists.txt).
std::span<const BuiltinScene> builtin_scenes();

}  // namespace relume

#pragma once

#include <string_view>

namespace relume {

/// The files of viewer/study/page/, built into the program by viewer/CMakeLists.txt.
struct PageParts {
  std::string_view style;    ///< page.css
  std::string_view plotly;   ///< plotly-basic.min.js
  std::string_view widgets;  ///< widgets.js
  std::string_view studies;  ///< studies.js
};

extern const PageParts page_parts;

}  // namespace relume

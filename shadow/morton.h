#pragma once

#include <algorithm>

#include "core/math/vec.h"

namespace relume {

/// Ten bits an axis of a place in a box, interleaved: places with neighbouring codes are near each
/// other. Places outside count as those on the box.
inline uint32_t morton_code(const Bounds& box, vec3 p) {
  uint32_t code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float extent = std::max(box.high[axis] - box.low[axis], 1e-30f);
    const float at = std::clamp((p[axis] - box.low[axis]) / extent, 0.0f, 1.0f);
    const auto cell = static_cast<uint32_t>(at * 1023);
    for (uint32_t bit = 0; bit < 10; ++bit) {
      code |= ((cell >> bit) & 1u) << (3 * bit + static_cast<uint32_t>(axis));
    }
  }
  return code;
}

}  // namespace relume

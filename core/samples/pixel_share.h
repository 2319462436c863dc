#pragma once

#include <cstdint>

namespace relume {

/// Which pixels of a picture have been shaded: every second one of every second row, or all.
enum class PixelShare : uint8_t { none, quarter, all };

/// The first share that holds pixel (x, y).
constexpr PixelShare first_share_of(int x, int y) {
  return x % 2 == 0 && y % 2 == 0 ? PixelShare::quarter : PixelShare::all;
}

}  // namespace relume

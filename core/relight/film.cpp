#include "core/relight/film.h"

#include <bit>
#include <cstring>

#include "core/base/check.h"

namespace relume {
namespace {

RareEvent replaced_pixels("pixel values replaced: not finite");

/// A loop without branches, which compilers turn into vector code.
bool all_finite(const float* values, int count) {
  uint32_t bad = 0;
  for (int i = 0; i < count; ++i) {
    const uint32_t exponent = std::bit_cast<uint32_t>(values[i]) & 0x7f800000u;
    bad |= exponent == 0x7f800000u ? 1u : 0u;
  }
  return bad == 0;
}

}  // namespace

void Film::write(int x, int y, vec3 rgb) {
  float* pixel = image_.at(x, y);
  for (int c = 0; c < 3; ++c) {
    const bool ok = is_finite(rgb[c]);
    if (!ok) [[unlikely]] {
      replaced_.fetch_add(1, std::memory_order_relaxed);
      replaced_pixels.add();
    }
    pixel[c] = ok ? rgb[c] : 0.0f;
  }
}

void Film::write_row(int x, int y, int count, const float* rgb) {
  if (all_finite(rgb, 3 * count)) [[likely]] {
    std::copy_n(rgb, 3 * count, image_.at(x, y));
    return;
  }
  for (int i = 0; i < count; ++i) write(x + i, y, {rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]});
}

void Film::write_row_rgbx(int x, int y, int count, const float* rgbx) {
  if (!all_finite(rgbx, 4 * count)) [[unlikely]] {
    for (int i = 0; i < count; ++i) {
      write(x + i, y, {rgbx[4 * i], rgbx[4 * i + 1], rgbx[4 * i + 2]});
    }
    return;
  }
  float* out = image_.at(x, y);
  // Four floats a pixel but for the last: the fourth is overwritten by the next pixel.
  for (int i = 0; i < count - 1; ++i) std::memcpy(out + 3 * i, rgbx + 4 * i, 4 * sizeof(float));
  if (count > 0) std::memcpy(out + 3 * (count - 1), rgbx + 4 * (count - 1), 3 * sizeof(float));
}

}  // namespace relume

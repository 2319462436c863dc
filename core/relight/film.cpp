#include "core/relight/film.h"

#include "core/base/check.h"

namespace relume {
namespace {

RareEvent replaced_pixels("pixel values replaced: not finite");

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

}  // namespace relume

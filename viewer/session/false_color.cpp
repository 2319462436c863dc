#include "viewer/session/false_color.h"

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/math/color.h"

namespace relume {
namespace {

constexpr std::array<vec3, 12> stop_colors = {
    vec3(0.24f, 0.08f, 0.36f), vec3(0.30f, 0.14f, 0.56f), vec3(0.22f, 0.26f, 0.72f),
    vec3(0.14f, 0.42f, 0.80f), vec3(0.10f, 0.60f, 0.72f), vec3(0.46f, 0.46f, 0.46f),
    vec3(0.56f, 0.56f, 0.56f), vec3(0.28f, 0.68f, 0.28f), vec3(0.66f, 0.80f, 0.22f),
    vec3(0.96f, 0.84f, 0.20f), vec3(0.98f, 0.56f, 0.14f), vec3(0.90f, 0.20f, 0.14f)};

}  // namespace

vec3 false_color(float stops) {
  if (!(stops >= false_color_low)) return vec3(0);
  if (stops >= false_color_high) return vec3(1);
  return stop_colors[static_cast<size_t>(stops - false_color_low)];
}

void apply_false_color(const Image& image, float exposure, std::span<uint8_t> rgba) {
  CHECK_MSG(rgba.size() == 4 * image.pixel_count(), "{} bytes for {} pixels", rgba.size(),
            image.pixel_count());
  const float scale = std::exp2(exposure) / middle_grey;
  parallel_for(image.pixel_count(), 16384, [&](size_t begin, size_t end) {
    for (size_t pixel = begin; pixel < end; ++pixel) {
      const vec3 color = false_color(std::log2(luminance(image.rgb(pixel)) * scale));
      for (int c = 0; c < 3; ++c) {
        rgba[4 * pixel + c] = static_cast<uint8_t>(255.0f * color[c] + 0.5f);
      }
      rgba[4 * pixel + 3] = 255;
    }
  });
}

}  // namespace relume

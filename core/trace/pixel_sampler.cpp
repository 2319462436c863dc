#include "core/trace/pixel_sampler.h"

#include "core/base/check.h"

namespace relume {

PixelStrata make_pixel_strata(int spp) {
  CHECK_MSG(spp >= 1 && spp <= 4096, "spp {}", spp);
  PixelStrata strata;
  strata.spp = spp;
  const int root = static_cast<int>(std::floor(std::sqrt(static_cast<double>(spp))));
  for (int rows = root; rows >= 1; --rows) {
    if (spp % rows == 0 && spp / rows <= 2 * rows) {
      strata.columns.assign(rows, spp / rows);
      return strata;
    }
  }
  const int rows = static_cast<int>(std::lround(std::sqrt(static_cast<double>(spp))));
  for (int row = 0; row < rows; ++row) {
    strata.columns.push_back(spp * (row + 1) / rows - spp * row / rows);
  }
  return strata;
}

void sample_pixel(const PixelStrata& strata, uint64_t seed, uint64_t pixel,
                  std::vector<vec2>& positions) {
  Random random(seed, RandomStream::pixel_samples, pixel);
  const float below_one = 0x1.fffffep-1f;
  const float cell = 1.0f / static_cast<float>(strata.spp);
  float top = 0;
  for (const int columns : strata.columns) {
    const float height = static_cast<float>(columns) * cell;
    for (int column = 0; column < columns; ++column) {
      const float x = (static_cast<float>(column) + random.uniform()) / static_cast<float>(columns);
      const float y = top + height * random.uniform();
      positions.push_back(glm::min(vec2(x, y), vec2(below_one)));
    }
    top += height;
  }
}

}  // namespace relume

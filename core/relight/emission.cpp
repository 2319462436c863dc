#include "core/relight/emission.h"

#include <limits>

#include "core/samples/sample_tile.h"

namespace relume {

Image emission_image(const RelightCache& cache) {
  Image image(cache.info().width, cache.info().height);
  if (cache.info().has_emission) image.pixels = cache.emission();
  return image;
}

void add_emission(const RelightCache& cache, const PackedTile& tile, Image& frame) {
  for (int b = 0; b < tile.block_count; ++b) {
    const PackedBlock block = cache.block(tile, b);
    for (int lane = 0; lane < block.lanes; ++lane) {
      const int x = block.pixels[lane] % tile_size;
      const int y = block.pixels[lane] / tile_size;
      const float* const emission = tile.emission + size_t{3} * (y * tile.width + x);
      float* const pixel = frame.at(tile.x0 + x, tile.y0 + y);
      for (int c = 0; c < 3; ++c) {
        pixel[c] = std::min(pixel[c] + emission[c], std::numeric_limits<float>::max());
      }
    }
  }
}

}  // namespace relume

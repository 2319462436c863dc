#include "core/relight/layer.h"

#include "core/samples/sample_tile.h"

namespace relume {

LayerLayout::LayerLayout(const RelightCache& cache) {
  first_block_.push_back(0);
  for (const PackedTile& tile : cache.tiles()) {
    first_block_.push_back(first_block_.back() + tile.block_count);
  }
}

void Layer::allocate(const LayerLayout& layout) {
  static_assert(block_floats * sizeof(float) % sizeof(CacheChunk) == 0);
  chunks_ = layout.blocks() * (block_floats * sizeof(float) / sizeof(CacheChunk));
  memory_ = std::make_unique_for_overwrite<CacheChunk[]>(chunks_);
  lit_.assign(layout.tiles(), 0);
  share = PixelShare::none;
}

BlockPixels::BlockPixels(const RelightCache& cache) : cache_(cache) {
  for (int pixel = 0; pixel < tile_size * tile_size; ++pixel) {
    offsets_.push_back(3 * (pixel / tile_size * cache.info().width + pixel % tile_size));
  }
}

void BlockPixels::write(const PackedTile& tile, int blocks, const float* sums, Image& image) const {
  float* const corner = image.at(tile.x0, tile.y0);
  for (int b = 0; b < blocks; ++b) {
    const PackedBlock block = cache_.block(tile, b);
    const float* const rgb = sums + b * block_floats;
    for (int lane = 0; lane < block.lanes; ++lane) {
      float* const pixel = corner + offsets_[block.pixels[lane]];
      for (int c = 0; c < 3; ++c) pixel[c] = rgb[c * block_lanes + lane];
    }
  }
}

}  // namespace relume

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

BlockPixels::BlockPixels(const RelightCache& cache, const BlockKernels& kernels)
    : cache_(cache), kernels_(kernels) {
  for (int pixel = 0; pixel < tile_size * tile_size; ++pixel) {
    offsets_.push_back(3 * (pixel / tile_size * cache.info().width + pixel % tile_size));
  }
}

void BlockPixels::write(const PackedTile& tile, int blocks, const float* sums, Image& image) const {
  float* const corner = image.at(tile.x0, tile.y0);
  for (int b = 0; b < blocks; ++b) {
    const PackedBlock block = cache_.block(tile, b);
    kernels_.write_pixels(sums + b * block_floats, block.pixels, block.lanes, offsets_.data(),
                          corner);
  }
}

}  // namespace relume

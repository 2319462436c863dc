#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/image/image.h"
#include "core/relight/kernel.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Where the blocks of a cache's tiles lie in its layers: layers hold nothing where the picture has
/// no geometry.
class LayerLayout {
 public:
  explicit LayerLayout(const RelightCache& cache);

  /// Index of a tile's first float.
  size_t first(size_t tile) const { return first_block_[tile] * size_t{block_floats}; }
  size_t blocks() const { return first_block_.back(); }
  size_t tiles() const { return first_block_.size() - 1; }

 private:
  std::vector<size_t> first_block_;  ///< tiles + 1
};

/// The response of every pixel to one light at weight 1, block after block of the cache: 16 reds,
/// 16 greens, 16 blues. Finite.
class Layer {
 public:
  /// Which pixels it holds.
  PixelShare share = PixelShare::none;

  /// Takes memory, which holds nothing yet.
  void allocate(const LayerLayout& layout);
  bool is_allocated() const { return !lit_.empty(); }
  size_t size_bytes() const { return chunks_ * sizeof(CacheChunk); }

  float* tile(const LayerLayout& layout, size_t t) { return floats() + layout.first(t); }
  const float* tile(const LayerLayout& layout, size_t t) const {
    return const_cast<Layer*>(this)->tile(layout, t);
  }
  /// False where the light reaches nothing of a tile, of which the layer then holds nothing.
  bool is_lit(size_t t) const { return lit_[t] != 0; }
  void set_lit(size_t t, bool lit) { lit_[t] = lit ? 1 : 0; }

 private:
  float* floats() { return reinterpret_cast<float*>(memory_.get()); }

  std::unique_ptr<CacheChunk[]> memory_;
  size_t chunks_ = 0;
  std::vector<uint8_t> lit_;  ///< per tile; bytes, since threads write neighbours at once
};

/// The sums of a tile's first blocks as pixels of `image`, which has three channels.
class BlockPixels {
 public:
  BlockPixels(const RelightCache& cache, const BlockKernels& kernels);
  void write(const PackedTile& tile, int blocks, const float* sums, Image& image) const;

 private:
  const RelightCache& cache_;
  const BlockKernels& kernels_;
  std::vector<int> offsets_;  ///< of each pixel of a tile in an image, in floats
};

}  // namespace relume

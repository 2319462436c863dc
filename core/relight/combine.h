#pragma once

#include <vector>

#include "core/relight/layer.h"
#include "core/relight/tile_shader.h"

namespace relume {

/// One layer of a weighted sum.
struct LayerTerm {
  const Layer* layer = nullptr;
  vec3 weight{0};
  /// Which of the lights that the same pass shades, whose sums are in the scratch; -1: none.
  int shaded = -1;
};

/// What a frame is the sum of, in this order.
struct LayerTerms {
  std::vector<LayerTerm> kept;    ///< their sum is also written to `keep`, unless that is null
  std::vector<LayerTerm> full;    ///< known in all pixels
  std::vector<LayerTerm> coarse;  ///< known in the pixels of `share`; the others are filled in
  PixelShare share = PixelShare::all;
  Layer* keep = nullptr;
};

/// Sums layers, tile by tile, and writes the frame. Thread-safe for different tiles.
class Combiner {
 public:
  Combiner(const RelightCache& cache, const LayerLayout& layout, const BlockKernels& kernels,
           LayerTerms terms, Image& frame);

  /// Writes a tile of the frame; returns how many values were not finite and became 0.
  int combine(size_t t, TileScratch& scratch) const;

  /// Asks for the part of the frame that combine() of a tile will write, and for what it will read
  /// beside the scratch, if that is little.
  void prefetch(size_t t) const;

 private:
  bool add(const std::vector<LayerTerm>& terms, size_t t, int blocks, TileScratch& scratch,
           float* sums) const;

  const RelightCache& cache_;
  const LayerLayout& layout_;
  const BlockKernels& kernels_;
  BlockPixels pixels_;
  LayerTerms terms_;
  Image& frame_;
};

}  // namespace relume

#pragma once

#include <span>
#include <vector>

#include "core/relight/block_decoder.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Some of a tile's blocks: [first, end).
struct BlockRange {
  int first = 0;
  int end = max_tile_blocks;
};

/// What shading a tile needs of memory; make one per thread and reuse it.
struct TileScratch {
  std::vector<CacheChunk> sums;
  std::vector<float> visibility[max_tile_blocks];
  std::vector<float> decoded;
  std::vector<KernelLight> lights;  ///< of the pass that reach the tile
  std::vector<size_t> places;       ///< per light of the pass: which of `lights`, if it is

  /// Out: the sums of the tile's blocks under a light, each block at its place.
  float* light_sums(size_t light) {
    return reinterpret_cast<float*>(sums.data()) + light * tile_floats;
  }
};

/// Shades the tiles of a cache. Thread-safe; a pixel's sum does not depend on the other lights.
class TileShader {
 public:
  /// `cache` must outlive the shader. `set` as in RelightParams.
  TileShader(const RelightCache& cache, InstructionSet set);

  /// Sums the records of a tile's blocks in `range` under each light at weight 1, into
  /// scratch.light_sums(). Lights of one kind that lie together are shaded together. `shadows`
  /// null: everything is visible; else it was made ready for the one light.
  void shade(const PackedTile& tile, std::span<const KernelLight> lights,
             const VisibilitySource* shadows, TileScratch& scratch, BlockRange range = {}) const;

  const BlockKernels& kernels() const { return kernels_; }

 private:
  void find_blocks(const PackedTile& tile, BlockRange range, const VisibilitySource* shadows,
                   TileScratch& scratch, KernelBlock* blocks) const;

  const RelightCache& cache_;
  BlockDecoder decoder_;
  BlockKernels kernels_;
};

}  // namespace relume

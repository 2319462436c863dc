#pragma once

#include <span>
#include <vector>

#include "core/relight/block_decoder.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/samples/sample_tile.h"

namespace relume {

/// What shading a tile needs of memory; make one per thread and reuse it.
struct TileScratch {
  /// Out: the tile's sums under each light, tile_size rows of tile_size pixels of four floats: RGB
  /// and 0. Pixels without records are 0.
  alignas(64) float rgbx[max_kernel_lights][tile_size * tile_size * 4];
  std::vector<float> visibility[max_kernel_blocks];
  std::vector<float> decoded;
};

/// Shades the tiles of a cache. Thread-safe; a pixel's sum does not depend on the other lights.
class TileShader {
 public:
  /// `cache` must outlive the shader. `set` as in RelightParams.
  TileShader(const RelightCache& cache, InstructionSet set);

  /// Sums the records of a tile under `count` lights of one kind, 1 to max_kernel_lights, each at
  /// weight 1, into scratch.rgbx. `shadows` null: everything is visible; else it was made ready for
  /// the one light.
  void shade(const PackedTile& tile, std::span<const KernelLight> lights,
             const VisibilitySource* shadows, TileScratch& scratch) const;

 private:
  const RelightCache& cache_;
  BlockDecoder decoder_;
  BlockKernels kernels_;
};

}  // namespace relume

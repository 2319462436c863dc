#include "core/relight/tile_shader.h"

#include "core/base/check.h"
#include "core/relight/receivers.h"

namespace relume {

TileShader::TileShader(const RelightCache& cache, InstructionSet set)
    : cache_(cache), decoder_(cache, set), kernels_(block_kernels(choose_instruction_set(set))) {}

void TileShader::shade(const PackedTile& tile, std::span<const KernelLight> lights,
                       const VisibilitySource* shadows, TileScratch& scratch) const {
  CHECK_MSG(!lights.empty() && lights.size() <= max_kernel_lights, "{} lights", lights.size());
  CHECK_MSG(shadows == nullptr || lights.size() == 1, "{} lights", lights.size());
  const CacheInfo& info = cache_.info();
  KernelBlock blocks[max_kernel_blocks];
  KernelTile kernel{blocks,
                    0,
                    info.format,
                    decoder_.shaders().data(),
                    static_cast<int>(info.types.size()),
                    &cache_.view_axes(),
                    lights.data(),
                    static_cast<int>(lights.size()),
                    {}};
  for (size_t i = 0; i < lights.size(); ++i) {
    std::fill(std::begin(scratch.rgbx[i]), std::end(scratch.rgbx[i]), 0.0f);
    kernel.rgbx[i] = scratch.rgbx[i];
  }
  for (int first = 0; first < tile.block_count; first += max_kernel_blocks) {
    kernel.block_count = std::min(max_kernel_blocks, tile.block_count - first);
    for (int i = 0; i < kernel.block_count; ++i) {
      const PackedBlock block = cache_.block(tile, first + i);
      blocks[i] = {block.words, block.frame, block.slots, nullptr, block.pixels, block.lanes};
      if (shadows == nullptr) continue;
      const float* records = decoder_.floats(block, scratch.decoded);
      query_block(info, block, records, *shadows, scratch.visibility[i]);
      blocks[i].visibility = scratch.visibility[i].data();
    }
    kernels_.shade_blocks(kernel);
  }
}

}  // namespace relume

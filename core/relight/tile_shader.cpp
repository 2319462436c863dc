#include "core/relight/tile_shader.h"

#include "core/base/check.h"
#include "core/relight/receivers.h"
#include "core/shade/shaders.h"

namespace relume {

TileShader::TileShader(const RelightCache& cache, InstructionSet set)
    : cache_(cache), shade_blocks_(block_kernel(choose_instruction_set(set))) {
  const auto table = shader_table();
  for (const SampleType& type : cache.info().types) {
    const auto found = std::find(table.begin(), table.end(), type.shader);
    CHECK(found != table.end());
    shaders_.push_back(static_cast<int>(found - table.begin()));
  }
}

void TileShader::shade(const PackedTile& tile, std::span<const KernelLight> lights,
                       const VisibilitySource* shadows, TileScratch& scratch) const {
  CHECK_MSG(!lights.empty() && lights.size() <= max_kernel_lights, "{} lights", lights.size());
  CHECK_MSG(shadows == nullptr || lights.size() == 1, "{} lights", lights.size());
  const CacheInfo& info = cache_.info();
  const vec3 eye = info.camera.eye;
  KernelBlock blocks[max_kernel_blocks];
  KernelTile kernel{blocks,
                    0,
                    shaders_.data(),
                    static_cast<int>(shaders_.size()),
                    {eye.x, eye.y, eye.z},
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
      blocks[i] = {block.data, block.slots, nullptr, block.pixels, block.lanes};
      if (shadows == nullptr) continue;
      query_block(info, block, *shadows, scratch.visibility[i]);
      blocks[i].visibility = scratch.visibility[i].data();
    }
    shade_blocks_(kernel);
  }
}

}  // namespace relume

#include "core/relight/tile_shader.h"

#include "core/base/check.h"
#include "core/relight/receivers.h"

namespace relume {
namespace {

/// How many of the first lights one pass takes: of one kind, as many as the kernels can.
size_t lights_of_a_pass(std::span<const KernelLight> lights) {
  size_t count = 1;
  while (count < lights.size() && count < max_kernel_lights &&
         lights[count].kind == lights[0].kind) {
    ++count;
  }
  return count;
}

}  // namespace

TileShader::TileShader(const RelightCache& cache, InstructionSet set)
    : cache_(cache), decoder_(cache, set), kernels_(block_kernels(choose_instruction_set(set))) {}

void TileShader::find_blocks(const PackedTile& tile, BlockRange range,
                             const VisibilitySource* shadows, TileScratch& scratch,
                             KernelBlock* blocks) const {
  const size_t types = cache_.info().types.size();
  const auto known = shadows != nullptr ? shadows->all_visibility() : std::span<const float>();
  CHECK_MSG(known.empty() || known.size() == cache_.slot_count() * block_lanes, "{} {}",
            known.size(), cache_.slot_count());
  size_t receiver = tile.first_slot * block_lanes;
  for (int b = 0; b < range.end; ++b) {
    const PackedBlock block = cache_.block(tile, b);
    const size_t first = receiver;
    for (size_t t = 0; t < types; ++t) receiver += size_t{block.slots[t]} * block_lanes;
    if (b < range.first) continue;
    KernelBlock& out = blocks[b - range.first];
    out = {block.words, block.frame, block.slots, nullptr};
    if (shadows == nullptr) continue;
    if (known.empty()) {
      const float* records = decoder_.floats(block, scratch.decoded);
      query_block(cache_.info(), block, records, first, *shadows, scratch.visibility[b]);
      out.visibility = scratch.visibility[b].data();
    } else {
      out.visibility = known.data() + first;
    }
  }
}

void TileShader::shade(const PackedTile& tile, std::span<const KernelLight> lights,
                       const VisibilitySource* shadows, TileScratch& scratch,
                       BlockRange range) const {
  CHECK_MSG(shadows == nullptr || lights.size() == 1, "{} lights", lights.size());
  range.end = std::min(range.end, tile.block_count);
  constexpr size_t chunk_floats = sizeof(CacheChunk) / sizeof(float);
  const size_t chunks = lights.size() * (tile_floats / chunk_floats);
  if (scratch.sums.size() < chunks) scratch.sums.resize(chunks);
  if (range.first >= range.end) return;
  KernelBlock blocks[max_tile_blocks];
  find_blocks(tile, range, shadows, scratch, blocks);
  for (size_t first = 0; first < lights.size();) {
    const size_t count = lights_of_a_pass(lights.subspan(first));
    kernels_.shade_blocks({blocks, range.end - range.first, cache_.info().format,
                           decoder_.shaders().data(), static_cast<int>(cache_.info().types.size()),
                           &cache_.view_axes(), &lights[first], static_cast<int>(count),
                           scratch.light_sums(first) + range.first * block_floats});
    first += count;
  }
}

}  // namespace relume

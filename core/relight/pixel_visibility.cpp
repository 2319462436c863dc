#include "core/relight/pixel_visibility.h"

#include <atomic>

#include "core/base/parallel.h"
#include "core/relight/block_decoder.h"
#include "core/relight/receivers.h"
#include "core/samples/sample_tile.h"

namespace relume {
namespace {

/// Calls visit(tile, block, records, visibility) for each block, tiles in parallel; `visibility`
/// holds 16 values a slot.
template <class Visit>
void for_each_block(const RelightCache& cache, const VisibilitySource& source, const Visit& visit) {
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  const auto tiles = cache.tiles();
  parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
    std::vector<float> decoded;
    std::vector<float> visibility;
    for (size_t t = begin; t < end; ++t) {
      size_t receiver = tiles[t].first_slot * block_lanes;
      for (int b = 0; b < tiles[t].block_count; ++b) {
        const PackedBlock block = cache.block(tiles[t], b);
        const float* records = decoder.floats(block, decoded);
        query_block(cache.info(), block, records, receiver, source, visibility);
        visit(tiles[t], block, records, visibility);
        receiver += visibility.size();
      }
    }
  });
}

/// Weighted mean of one lane's visibility; 0 without records.
float lane_visibility(const CacheInfo& info, const PackedBlock& block, const float* records,
                      int lane, const float* visibility) {
  double seen = 0;
  double weight = 0;
  for (size_t t = 0; t < info.types.size(); ++t) {
    for (int slot = 0; slot < block.slots[t]; ++slot) {
      if (records[lane] > 0) {
        seen += double{records[lane]} * visibility[lane];
        weight += records[lane];
      }
      records += (1 + info.types[t].width) * block_lanes;
      visibility += block_lanes;
    }
  }
  return weight > 0 ? static_cast<float>(std::min(1.0, seen / weight)) : 0.0f;
}

}  // namespace

std::vector<float> pixel_visibility(const RelightCache& cache, const VisibilitySource& source) {
  const CacheInfo& info = cache.info();
  std::vector<float> pixels(static_cast<size_t>(info.width) * info.height, 0.0f);
  for_each_block(cache, source,
                 [&](const PackedTile& tile, const PackedBlock& block, const float* records,
                     const std::vector<float>& visibility) {
                   for (int lane = 0; lane < block.lanes; ++lane) {
                     const size_t x = tile.x0 + block.pixels[lane] % tile_size;
                     const size_t y = tile.y0 + block.pixels[lane] / tile_size;
                     pixels[y * info.width + x] =
                         lane_visibility(info, block, records, lane, visibility.data());
                   }
                 });
  return pixels;
}

uint64_t query_cache(const RelightCache& cache, const VisibilitySource& source) {
  if (!source.all_visibility().empty()) return cache.slot_count();
  std::atomic<uint64_t> slots{0};
  for_each_block(cache, source,
                 [&](const PackedTile&, const PackedBlock&, const float*,
                     const std::vector<float>& visibility) {
                   slots.fetch_add(visibility.size() / block_lanes, std::memory_order_relaxed);
                 });
  return slots;
}

}  // namespace relume

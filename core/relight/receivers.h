#pragma once

#include <functional>
#include <vector>

#include "core/relight/block_decoder.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// Asks `source` for the visibility of every record of a block: 16 values a slot, in slot order,
/// into `visibility` (resized). `records`: the block as BlockDecoder shows it. `first`: index of
/// its first receiver.
void query_block(const CacheInfo& info, const PackedBlock& block, const float* records,
                 size_t first, const VisibilitySource& source, std::vector<float>& visibility);

/// Sixteen receivers, a slot of the cache, with the samples that each stands for.
struct ReceiverGroup {
  Receivers receivers;
  int slot = 0;                        ///< within its block and type: one lane of them is one pixel
  PixelShare share = PixelShare::all;  ///< the first that holds its pixels
  std::array<Footprint, block_lanes> footprints;
  std::vector<Member> members;  ///< lane by lane, stored_members each
};

/// All receivers of a view in the cache's order: tile by tile, block by block, type by type, slot
/// by slot, 16 lanes each, padding included. What a shadow method learns once. Thread-safe.
class ViewReceivers {
 public:
  /// `cache` must outlive the view.
  explicit ViewReceivers(const RelightCache& cache);

  size_t count() const { return cache_.slot_count() * block_lanes; }
  size_t tile_count() const { return cache_.tiles().size(); }
  /// Index of the first receiver of a tile, or count() behind the last tile.
  size_t tile_first(size_t tile) const;
  /// Footprints are known; else every receiver is a single sample.
  bool has_footprints() const { return cache_.info().has_footprints; }
  /// Receivers of two samples and more have stored members.
  bool has_members() const { return cache_.info().has_members; }
  const CacheInfo& info() const { return cache_.info(); }

  /// Calls visit(group) for each group of a tile, in order, up to those of `share`, which come
  /// first. What a group points to is valid within the call.
  void visit_tile(size_t tile, const std::function<void(const ReceiverGroup&)>& visit,
                  PixelShare share = PixelShare::all) const;

 private:
  const RelightCache& cache_;
  BlockDecoder decoder_;
};

}  // namespace relume

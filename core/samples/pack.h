#pragma once

#include "core/samples/relight_cache.h"
#include "core/samples/sample_tile.h"

namespace relume {

/// A tile in the cache's own layout, ready to be written.
struct PackedTileData {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  uint32_t block_count = 0;
  uint64_t record_count = 0;
  CacheFormat format = CacheFormat::exact;
  std::vector<uint32_t> words;         ///< blocks' data
  std::vector<std::byte> blocks;       ///< block_count headers
  std::vector<uint8_t> coverage;       ///< width * height
  std::vector<float> predicted_error;  ///< width * height, 0 where coverage is 0; or empty
  std::vector<float> emission;         ///< width * height * 3, or empty
  bool has_footprints = false;
  bool has_members = false;
  std::vector<uint32_t> footprints;    ///< per slot: 16 lanes of each of footprint_words words
  std::vector<uint8_t> member_counts;  ///< per slot: 16 lanes
  std::vector<PackedMember> members;   ///< slot by slot, lane by lane
};

struct PackParams {
  CacheFormat format = CacheFormat::exact;
  Camera camera;  ///< the cache's; packed formats keep positions as it sees them
};

/// Packs the records of a tile, one SIMD lane a pixel: the pixels of each share are sorted by how
/// many records they have of each type and cut into blocks of 16, so that lanes of a block stay
/// full and a coarse picture reads the front of each tile; pixels without records vanish. A
/// predicted error must be >= 0 or NaN; what is not finite becomes the largest float and is
/// counted, what has no coverage becomes 0. Deterministic.
PackedTileData pack_tile(const SampleTile& records, std::span<const SampleType> types,
                         const PackParams& params = {});

}  // namespace relume

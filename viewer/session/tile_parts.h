#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/samples/pack.h"

namespace relume {

/// Some of a view's tiles, packed, and what it took to make them: what one process of several adds
/// to a cache.
struct TilePart {
  std::vector<PackedTileData> tiles;
  uint64_t samples = 0;
  double sample_ms = 0;  ///< summed over threads, as in PrepareStats
  double reduce_ms = 0;
  double pack_ms = 0;
};

/// As bytes of this machine's order.
std::vector<std::byte> to_bytes(const TilePart& part);

/// Back. Throws Error(input) naming `place` where the bytes are none of to_bytes().
TilePart read_tile_part(std::span<const std::byte> bytes, const std::string& place);

}  // namespace relume

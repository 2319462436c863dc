#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/samples/relight_cache.h"
#include "core/scene/limits.h"

namespace relume {

// The .relume file, version 6, little-endian (docs/cache-format.md):
//   CacheHeader | chunks, each 64-byte aligned | info | TileEntry[tile_count]
// The tiles are those of the image, row by row. The chunks of a row of tiles follow each other,
// then their footprint chunks. A tile chunk: data (words of 4 bytes, see PackedBlock), block
// headers, coverage bytes; where the info says so, pad to 4 and one float a pixel of predicted
// error; where it says so, pad to 4 and three floats a pixel of emission. A block header: u32 first
// word of the block's data | u8 lanes | u8 pixels[16] | pad to 24 | u16 slots[type_count] | packed
// formats: pad to 4, float frame[6], float bias[type_count] | pad to 8. A footprint chunk, which
// shading without shadows does not read: per slot of the tile, in the data's order, 16 lanes of
// each word of its records' footprints (footprint.h); where the info says so, per slot 16 bytes of
// how many members each lane's record stored, and the members, lane by lane.

inline constexpr std::array<char, 8> cache_magic = {'R', 'E', 'L', 'U', 'M', 'E', '\r', '\n'};
inline constexpr uint32_t cache_version = 6;
inline constexpr uint32_t cache_endian_mark = 0x01020304;
inline constexpr int max_slots = 4096;  ///< of one type in one block: samples a pixel

struct CacheHeader {
  std::array<char, 8> magic = cache_magic;
  uint32_t version = cache_version;
  uint32_t endian = cache_endian_mark;
  uint64_t file_size = 0;
  uint64_t info_offset = 0;
  uint64_t info_size = 0;
  uint64_t directory_offset = 0;
  uint64_t tile_count = 0;
  uint64_t index_hash = 0;  ///< XXH3 of info and directory, seeded with the fields above
};
static_assert(sizeof(CacheHeader) == 64);

struct TileEntry {
  uint16_t x0 = 0;
  uint16_t y0 = 0;
  uint16_t width = 0;
  uint16_t height = 0;
  uint32_t block_count = 0;
  uint32_t reserved = 0;
  uint64_t offset = 0;      ///< of the chunk in the file, a multiple of 64
  uint64_t data_words = 0;  ///< then the block headers start
  uint64_t size = 0;        ///< bytes of the chunk
  uint64_t hash = 0;        ///< XXH3 of the chunk
  // The tile's footprint chunk; zeros where the cache has none.
  uint64_t footprint_offset = 0;  ///< in the file, a multiple of 64
  uint64_t footprint_size = 0;    ///< bytes
  uint64_t footprint_hash = 0;    ///< XXH3
};
static_assert(sizeof(TileEntry) == 72);

/// Where a packed format's frame is in a block header.
constexpr size_t block_frame_offset(size_t type_count) {
  return (block_slots_offset + 2 * type_count + 3) / 4 * 4;
}

/// Bytes of one block header.
constexpr size_t block_stride(size_t type_count, CacheFormat format) {
  const size_t floats = format == CacheFormat::exact ? 0 : block_frame_floats + type_count;
  return (block_frame_offset(type_count) + floats * sizeof(float) + 7) / 8 * 8;
}

/// Bytes of the coverage of `pixels` pixels, padded so that floats may follow.
constexpr size_t coverage_stride(size_t pixels) {
  return (pixels + 3) / 4 * 4;
}
inline constexpr size_t footprint_slot_bytes = footprint_words * block_lanes * sizeof(uint32_t);

/// XXH3 of `bytes`.
uint64_t hash_bytes(std::span<const std::byte> bytes, uint64_t seed = 0);

/// Hash of header fields, info and directory.
uint64_t index_hash(const CacheHeader& header, std::span<const std::byte> info,
                    std::span<const std::byte> directory);

/// CacheInfo as bytes, and back. The reader throws Error(input) on anything that does not fit;
/// every count is checked against the bytes left before memory is taken.
std::vector<std::byte> encode_info(const CacheInfo& info);
CacheInfo decode_info(std::span<const std::byte> bytes, std::span<const ShaderInfo* const> shaders,
                      const std::string& place);

}  // namespace relume

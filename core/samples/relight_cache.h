#pragma once

#include <cstring>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/mapped_file.h"
#include "core/math/vec.h"
#include "core/samples/footprint.h"
#include "core/samples/pixel_share.h"
#include "core/samples/record_layout.h"
#include "core/samples/sample_type.h"

namespace relume {

inline constexpr int block_lanes = 16;      ///< pixels of a block; one SIMD lane is one pixel
inline constexpr int max_tile_blocks = 16;  ///< a tile of 16 x 16 pixels has no more

/// Memory of a cache that was not read from a file, in aligned pieces.
struct alignas(64) CacheChunk {
  std::byte bytes[64];
};
using CacheBytes = std::vector<CacheChunk>;

/// All that a cache says about itself, as stored in its header. Everything needed to relight
/// without the scene, and the scene's text so that traced shadows can be had from it.
struct CacheInfo {
  int width = 0;   ///< pixels
  int height = 0;  ///< pixels
  Camera camera;
  std::vector<SampleType> types;
  Bounds bounds;  ///< of the scene, world
  CacheFormat format = CacheFormat::exact;
  std::string method;         ///< reduction label: "kmeans", "pure", ..., "all" = not reduced
  int records = 0;            ///< k asked for per pixel
  float average_records = 0;  ///< budget asked for: mean records per covered pixel; 0 = none
  float target_error = 0;     ///< budget asked for: predicted error of a pixel; 0 = none
  int spp = 0;                ///< samples per pixel taken
  uint64_t seed = 0;
  uint64_t sample_count = 0;         ///< samples that hit, before reduction
  uint64_t record_count = 0;         ///< records stored, padding excluded
  bool has_predicted_error = false;  ///< tiles carry one predicted error a pixel
  bool has_footprints = false;       ///< records carry theirs; else each is a sample
  bool has_members = false;          ///< records carry some of their samples
  bool has_emission = false;         ///< tiles carry what pixels emit by themselves
  std::string scene_name;
  std::string scene_file;     ///< absolute path or built-in label
  std::string scene_text;     ///< the scene file's text
  std::vector<Light> lights;  ///< the scene's lights when prepared
  Light representative_low;
  Light representative_high;
  float exposure = 0;
};

struct TileEntry;  // core/samples/cache_format.h

/// Where the parts of a block header are, see core/samples/cache_format.h.
inline constexpr size_t block_lanes_offset = 4;
inline constexpr size_t block_pixels_offset = 5;
inline constexpr size_t block_slots_offset = 24;

/// Sixteen pixels of a tile. For each type t in order it has slots[t] slots; a slot holds, for each
/// of 16 lanes, one record, as the format lays it out (make_record_layout): 16 lanes of the first
/// word, 16 of the second ... In the exact format those are 16 weights, then 16 floats for each of
/// the type's `width` components; missing records have weight 0 and the values of some record of
/// the same slot (always finite). In packed formats missing records have no bit set.
struct PackedBlock {
  const uint32_t* words;  ///< first slot, 64-byte aligned within the cache
  const float* frame;     ///< of packed formats: block_frame_floats and a bias per type; else null
  const uint16_t* slots;  ///< per type
  const uint8_t* pixels;  ///< per lane: y * tile_size + x within the tile
  int lanes;              ///< lanes in use, 1..16; the others repeat lane 0's pixel with weight 0

  /// The words as floats, in the exact format.
  const float* floats() const { return reinterpret_cast<const float*>(words); }
};

/// Read access to one tile of a cache. Its blocks are sorted by the share of the picture that their
/// pixels belong to; a block lies in one share.
struct PackedTile {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  int block_count = 0;
  const std::byte* blocks = nullptr;  ///< block headers, see core/samples/cache_format.h
  const uint32_t* words = nullptr;    ///< all blocks' data
  const uint8_t* coverage = nullptr;  ///< per pixel of the tile, row-major: round(255 * coverage)
  /// Per pixel of the tile, row-major: finite, >= 0, 0 where coverage is 0. Null when the cache has
  /// none. See SampleTile::predicted_error.
  const float* predicted_error = nullptr;
  /// Per pixel of the tile, row-major: RGB, finite, >= 0. Null when the cache has none. See
  /// SampleTile::emission.
  const float* emission = nullptr;
  /// Of the tile's first slot, counted through the cache; 16 receivers (see Receivers) each.
  uint64_t first_slot = 0;
  const uint32_t* footprints = nullptr;    ///< per slot: footprint_words x 16; null = has none
  const uint8_t* member_counts = nullptr;  ///< per slot: 16; null = has none
  const PackedMember* members = nullptr;   ///< slot by slot, lane by lane
};

/// The packed, immutable records of one view: a memory-mapped .relume file or the same bytes in
/// memory. Thread-safe.
class RelightCache {
 public:
  /// Opens and checks a file: magic, version, every count and offset, checksums. Throws
  /// Error(input) or Error(limit); nothing is allocated that the file's own size does not justify.
  /// `shaders` is the program's table: a cache that names a shader or fields it lacks is refused.
  static RelightCache open(const std::filesystem::path& path,
                           std::span<const ShaderInfo* const> shaders);
  /// The same over the bytes of a whole cache in memory; `place` is used in messages.
  static RelightCache from_bytes(CacheBytes bytes, std::span<const ShaderInfo* const> shaders,
                                 const std::string& place);

  const CacheInfo& info() const { return info_; }
  /// How records of each type are stored, parallel to info().types.
  std::span<const RecordLayout> layouts() const { return layouts_; }
  /// What packed positions are relative to.
  const ViewAxes& view_axes() const { return view_axes_; }
  std::span<const PackedTile> tiles() const { return tiles_; }
  PackedBlock block(const PackedTile& tile, int index) const {
    const std::byte* header = tile.blocks + index * block_stride_;
    uint32_t first_word = 0;
    std::memcpy(&first_word, header, sizeof(first_word));
    const std::byte* frame = frame_offset_ > 0 ? header + frame_offset_ : nullptr;
    return {tile.words + first_word, reinterpret_cast<const float*>(frame),
            reinterpret_cast<const uint16_t*>(header + block_slots_offset),
            reinterpret_cast<const uint8_t*>(header + block_pixels_offset),
            static_cast<int>(header[block_lanes_offset])};
  }
  /// The number of blocks that hold the pixels of `share`, the first of the tile.
  int block_count(const PackedTile& tile, PixelShare share) const;
  /// Slots of all tiles and types; a slot is 16 records, missing ones included.
  uint64_t slot_count() const { return slot_count_; }
  /// The whole cache, as a .relume file holds it.
  std::span<const std::byte> bytes() const { return bytes_; }
  /// Bytes of the whole cache, header included.
  size_t size_bytes() const { return bytes_.size(); }
  /// XXH3 over all that the file says: equal hashes stand for equal caches.
  uint64_t hash() const;
  /// Bytes that shading without shadows reads: records and block headers.
  size_t shading_bytes() const;
  /// Fraction of each pixel that geometry covers, row-major, in [0, 1] (8-bit precision).
  std::vector<float> coverage() const;
  /// Predicted error of each pixel, row-major, >= 0, in the units of the picture; 0 where there is
  /// no geometry. Empty when info().has_predicted_error is false. See SampleTile::predicted_error.
  std::vector<float> predicted_error() const;
  /// What each pixel emits by itself, row-major RGB, scene-linear. Empty when info().has_emission
  /// is false.
  std::vector<float> emission() const;
  /// Number of records of each pixel over all types, row-major; 0 where there are none.
  std::vector<float> record_counts() const;

 private:
  RelightCache() = default;
  void parse(std::span<const ShaderInfo* const> shaders, const std::string& place);
  void check_footprints(const TileEntry& entry, PackedTile& tile, const std::string& place) const;
  uint64_t slots_of(const PackedTile& tile) const;
  void check_order(std::span<const std::byte> directory, const std::string& place) const;
  PackedTile check_tile(const TileEntry& entry, const std::string& place) const;

  MappedFile file_;
  CacheBytes memory_;
  std::span<const std::byte> bytes_;
  CacheInfo info_;
  size_t block_stride_ = 0;  ///< bytes of a block header
  size_t frame_offset_ = 0;  ///< of a packed format's frame in it; 0 = none
  std::vector<RecordLayout> layouts_;
  ViewAxes view_axes_;
  std::vector<PackedTile> tiles_;
  uint64_t slot_count_ = 0;
};

}  // namespace relume

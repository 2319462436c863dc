#pragma once

#include <filesystem>
#include <optional>

#include "core/base/file.h"
#include "core/samples/cache_format.h"
#include "core/samples/pack.h"

namespace relume {

/// Writes a cache tile by tile, into a file (crash-safe: temporary, fsync, rename) or into memory.
/// Tiles must come in a fixed order; the bytes then depend on the tiles and the info alone.
class CacheWriter {
 public:
  /// Into memory.
  CacheWriter();
  /// Into `path`. Throws Error(output).
  explicit CacheWriter(const std::filesystem::path& path);

  /// All tiles have one format, and carry a predicted error, footprints, members or emission, or
  /// none does.
  void add(const PackedTileData& tile);

  /// Writes info and directory. Counts of samples come in with `info`; record_count, format,
  /// has_predicted_error, has_footprints, has_members and has_emission follow from the tiles.
  /// File: renames it into place. Memory: take the result with take_bytes().
  void finish(CacheInfo info);
  CacheBytes take_bytes();

 private:
  void append(std::span<const std::byte> bytes);
  void append_footprints();
  void overwrite_header(const CacheHeader& header);

  std::optional<AtomicFile> file_;
  CacheBytes memory_;
  uint64_t size_ = 0;
  uint64_t record_count_ = 0;
  CacheFormat format_ = CacheFormat::exact;
  bool has_predicted_error_ = false;
  bool has_footprints_ = false;
  bool has_members_ = false;
  bool has_emission_ = false;
  std::vector<TileEntry> directory_;
  /// Footprint chunks of the last tiles, a row of them at most; they follow the row's tile chunks.
  std::vector<std::vector<std::byte>> footprints_;
};

}  // namespace relume

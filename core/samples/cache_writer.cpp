#include "core/samples/cache_writer.h"

#include <cstring>

#include "core/base/check.h"

namespace relume {
namespace {

constexpr size_t chunk_alignment = 64;

constexpr size_t align_up(size_t size, size_t alignment) {
  return (size + alignment - 1) / alignment * alignment;
}

void append_to(std::vector<std::byte>& chunk, std::span<const std::byte> bytes) {
  chunk.insert(chunk.end(), bytes.begin(), bytes.end());
}

}  // namespace

// Both start with an empty header, which finish() overwrites.
CacheWriter::CacheWriter() {
  const CacheHeader header;
  append(std::as_bytes(std::span(&header, 1)));
}

CacheWriter::CacheWriter(const std::filesystem::path& path) : file_(std::in_place, path) {
  const CacheHeader header;
  append(std::as_bytes(std::span(&header, 1)));
}

void CacheWriter::append(std::span<const std::byte> bytes) {
  if (bytes.empty()) return;
  if (file_) {
    file_->append(bytes);
  } else {
    memory_.resize(align_up(size_ + bytes.size(), chunk_alignment) / sizeof(CacheChunk));
    std::memcpy(reinterpret_cast<std::byte*>(memory_.data()) + size_, bytes.data(), bytes.size());
  }
  size_ += bytes.size();
}

void CacheWriter::overwrite_header(const CacheHeader& header) {
  const auto bytes = std::as_bytes(std::span(&header, 1));
  if (file_) {
    file_->write_at(0, bytes);
  } else {
    std::memcpy(memory_.data(), bytes.data(), bytes.size());
  }
}

/// Shading reads nothing of them: they lie apart from what it reads.
void CacheWriter::append_footprints() {
  const size_t first = directory_.size() - footprints_.size();
  for (size_t i = 0; i < footprints_.size(); ++i) {
    TileEntry& entry = directory_[first + i];
    entry.footprint_offset = size_;
    entry.footprint_size = footprints_[i].size();
    entry.footprint_hash = hash_bytes(footprints_[i]);
    append(footprints_[i]);
  }
  footprints_.clear();
}

void CacheWriter::add(const PackedTileData& tile) {
  if (!directory_.empty() && directory_.back().y0 != tile.y0) append_footprints();
  std::vector<std::byte> chunk;
  append_to(chunk, std::as_bytes(std::span(tile.words)));
  append_to(chunk, tile.blocks);
  append_to(chunk, std::as_bytes(std::span(tile.coverage)));
  const bool has_error = !tile.predicted_error.empty();
  const bool has_emission = !tile.emission.empty();
  if (directory_.empty()) {
    format_ = tile.format;
    has_predicted_error_ = has_error;
    has_footprints_ = tile.has_footprints;
    has_members_ = tile.has_members;
    has_emission_ = has_emission;
  }
  CHECK_MSG(tile.format == format_, "tile at {} {}", tile.x0, tile.y0);
  CHECK_MSG(has_error == has_predicted_error_ && tile.has_footprints == has_footprints_ &&
                tile.has_members == has_members_ && has_emission == has_emission_,
            "tile at {} {}", tile.x0, tile.y0);
  if (has_error) {
    CHECK_MSG(tile.predicted_error.size() == tile.coverage.size(), "{} {}",
              tile.predicted_error.size(), tile.coverage.size());
    chunk.resize(align_up(chunk.size(), sizeof(float)));
    append_to(chunk, std::as_bytes(std::span(tile.predicted_error)));
  }
  if (has_emission) {
    CHECK_MSG(tile.emission.size() == 3 * tile.coverage.size(), "{} {}", tile.emission.size(),
              tile.coverage.size());
    chunk.resize(align_up(chunk.size(), sizeof(float)));
    append_to(chunk, std::as_bytes(std::span(tile.emission)));
  }
  if (has_footprints_) {
    std::vector<std::byte>& footprints = footprints_.emplace_back();
    append_to(footprints, std::as_bytes(std::span(tile.footprints)));
    append_to(footprints, std::as_bytes(std::span(tile.member_counts)));
    append_to(footprints, std::as_bytes(std::span(tile.members)));
    footprints.resize(align_up(footprints.size(), chunk_alignment));
  }
  chunk.resize(align_up(chunk.size(), chunk_alignment));
  CHECK_MSG(size_ % chunk_alignment == 0, "size {}", size_);
  TileEntry entry;
  entry.x0 = static_cast<uint16_t>(tile.x0);
  entry.y0 = static_cast<uint16_t>(tile.y0);
  entry.width = static_cast<uint16_t>(tile.width);
  entry.height = static_cast<uint16_t>(tile.height);
  entry.block_count = tile.block_count;
  entry.offset = size_;
  entry.data_words = tile.words.size();
  entry.size = chunk.size();
  entry.hash = hash_bytes(chunk);
  directory_.push_back(entry);
  record_count_ += tile.record_count;
  append(chunk);
}

void CacheWriter::finish(CacheInfo info) {
  append_footprints();
  info.record_count = record_count_;
  info.format = format_;
  info.has_predicted_error = has_predicted_error_;
  info.has_footprints = has_footprints_;
  info.has_members = has_members_;
  info.has_emission = has_emission_;
  CacheHeader header;
  const std::vector<std::byte> encoded = encode_info(info);
  header.info_offset = size_;
  header.info_size = encoded.size();
  append(encoded);
  header.directory_offset = size_;
  header.tile_count = directory_.size();
  const auto directory = std::as_bytes(std::span(directory_));
  append(directory);
  header.file_size = size_;
  header.index_hash = index_hash(header, encoded, directory);
  overwrite_header(header);
  if (file_) file_->commit();
}

CacheBytes CacheWriter::take_bytes() {
  CHECK(!file_);
  return std::move(memory_);
}

}  // namespace relume

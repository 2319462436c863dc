#include "viewer/session/tile_parts.h"

#include <cstring>

#include "core/base/error.h"

namespace relume {
namespace {

class Writer {
 public:
  template <class T>
  void value(const T& x) {
    static_assert(std::is_trivially_copyable_v<T>);
    append(std::as_bytes(std::span(&x, 1)));
  }
  template <class T>
  void list(const std::vector<T>& values) {
    value(static_cast<uint64_t>(values.size()));
    append(std::as_bytes(std::span(values)));
  }
  void append(std::span<const std::byte> more) {
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  std::vector<std::byte> bytes;
};

class Reader {
 public:
  Reader(std::span<const std::byte> bytes, const std::string& place)
      : bytes_(bytes), place_(place) {}

  template <class T>
  void value(T& x) {
    std::memcpy(&x, take(1, sizeof(T)).data(), sizeof(T));
  }
  template <class T>
  void list(std::vector<T>& values) {
    uint64_t count = 0;
    value(count);
    const auto part = take(count, sizeof(T));
    values.resize(count);
    if (!part.empty()) std::memcpy(values.data(), part.data(), part.size());
  }
  bool at_end() const { return bytes_.empty(); }
  [[noreturn]] void fail() const {
    throw input_error(place_, "holds no tiles", "run the command again");
  }

 private:
  std::span<const std::byte> take(uint64_t count, size_t size) {
    if (count > bytes_.size() / size) fail();
    const auto part = bytes_.first(count * size);
    bytes_ = bytes_.subspan(count * size);
    return part;
  }

  std::span<const std::byte> bytes_;
  const std::string& place_;
};

// One description serves writing and reading.
template <class Archive, class Tile>
void visit_tile(Archive& archive, Tile& tile) {
  archive.value(tile.x0);
  archive.value(tile.y0);
  archive.value(tile.width);
  archive.value(tile.height);
  archive.value(tile.block_count);
  archive.value(tile.record_count);
  archive.value(tile.format);
  archive.list(tile.words);
  archive.list(tile.blocks);
  archive.list(tile.coverage);
  archive.list(tile.predicted_error);
  archive.list(tile.emission);
  archive.value(tile.has_footprints);
  archive.value(tile.has_members);
  archive.list(tile.footprints);
  archive.list(tile.member_counts);
  archive.list(tile.members);
}

template <class Archive, class Part>
void visit_counts(Archive& archive, Part& part) {
  archive.value(part.samples);
  archive.value(part.sample_ms);
  archive.value(part.reduce_ms);
  archive.value(part.pack_ms);
}

}  // namespace

std::vector<std::byte> to_bytes(const TilePart& part) {
  Writer writer;
  visit_counts(writer, part);
  for (const PackedTileData& tile : part.tiles) visit_tile(writer, tile);
  return std::move(writer.bytes);
}

TilePart read_tile_part(std::span<const std::byte> bytes, const std::string& place) {
  Reader reader(bytes, place);
  TilePart part;
  visit_counts(reader, part);
  while (!reader.at_end()) visit_tile(reader, part.tiles.emplace_back());
  return part;
}

}  // namespace relume

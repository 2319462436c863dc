#include "core/samples/relight_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/samples/cache_format.h"
#include "core/samples/record_encode.h"
#include "core/samples/sample_tile.h"

namespace relume {
namespace {

[[noreturn]] void corrupt(const std::string& place, const std::string& what) {
  throw input_error(place, "corrupt cache: " + what, "prepare the scene again");
}

/// True when [offset, offset + size) lies within `total`, without overflow.
bool inside(uint64_t offset, uint64_t size, uint64_t total) {
  return offset <= total && size <= total - offset;
}

size_t tiles_across(int pixels) {
  return static_cast<size_t>((pixels + tile_size - 1) / tile_size);
}

TileEntry read_entry(std::span<const std::byte> directory, size_t i) {
  TileEntry entry;
  std::memcpy(&entry, directory.data() + i * sizeof(entry), sizeof(entry));
  return entry;
}

CacheHeader read_header(std::span<const std::byte> bytes, const std::string& place) {
  CacheHeader header;
  if (bytes.size() < sizeof(header)) corrupt(place, "it is shorter than a header");
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != cache_magic) {
    throw input_error(place, "is not a .relume cache", "make one with relume prepare");
  }
  if (header.endian != cache_endian_mark || header.version != cache_version) {
    throw input_error(place,
                      fmt::format("has cache version {}, not {}", header.version, cache_version),
                      "prepare the scene again with this program");
  }
  // In memory the last chunk may be padded; a file has the exact size.
  if (header.file_size > bytes.size() || bytes.size() - header.file_size >= 64) {
    corrupt(place, fmt::format("{} bytes long instead of {}", bytes.size(), header.file_size));
  }
  if (!inside(header.info_offset, header.info_size, header.file_size) ||
      header.tile_count > header.file_size / sizeof(TileEntry) ||
      !inside(header.directory_offset, header.tile_count * sizeof(TileEntry), header.file_size)) {
    corrupt(place, "its index lies outside the file");
  }
  return header;
}

/// Largest u and v of a packed position: tangents of the widest field of view and more.
constexpr float max_view_tangent = 1e6f;

/// True for a frame that no code of which gives anything but a finite position and bias.
bool is_frame(const float* frame, size_t types) {
  for (int i = 0; i < 3; ++i) {
    const float low = frame[i];
    const float extent = frame[3 + i];
    const float largest = i < 2 ? max_view_tangent : 4 * max_coordinate;
    const bool ok = is_finite(low) && is_finite(extent) && std::abs(low) <= largest &&
                    extent >= 0 && extent <= 2 * largest;
    if (!ok) return false;
  }
  return std::all_of(frame + block_frame_floats, frame + block_frame_floats + types,
                     [](float bias) { return is_finite(bias) && bias >= 0; });
}

/// True when a lane of a slot holds a record.
bool is_present(const RecordLayout& layout, const uint32_t* lane) {
  if (layout.format == CacheFormat::exact) return std::bit_cast<float>(lane[0]) > 0;
  for (int f = 0; f < layout.field_count; ++f) {
    const PackedField& field = layout.fields[f];
    // The exponent of a black colour counts for nothing.
    const uint32_t color = lane[field.word[0] * block_lanes] & 0x07ffffffu;
    if (field.codec == Codec::color && color != 0) return true;
  }
  return false;
}

/// An image of value(tile, pixel of the tile), row-major.
template <class Value>
std::vector<float> gather(const CacheInfo& info, std::span<const PackedTile> tiles,
                          const Value& value) {
  std::vector<float> result(static_cast<size_t>(info.width) * info.height);
  for (const PackedTile& tile : tiles) {
    for (int y = 0; y < tile.height; ++y) {
      for (int x = 0; x < tile.width; ++x) {
        const size_t pixel = static_cast<size_t>(tile.y0 + y) * info.width + tile.x0 + x;
        result[pixel] = value(tile, y * tile.width + x);
      }
    }
  }
  return result;
}

}  // namespace

RelightCache RelightCache::open(const std::filesystem::path& path,
                                std::span<const ShaderInfo* const> shaders) {
  RelightCache cache;
  cache.file_ = MappedFile(path);
  cache.bytes_ = cache.file_.bytes();
  cache.parse(shaders, path.string());
  return cache;
}

RelightCache RelightCache::from_bytes(CacheBytes bytes, std::span<const ShaderInfo* const> shaders,
                                      const std::string& place) {
  RelightCache cache;
  cache.memory_ = std::move(bytes);
  cache.bytes_ = std::as_bytes(std::span(cache.memory_));
  cache.parse(shaders, place);
  return cache;
}

void RelightCache::check_order(std::span<const std::byte> directory,
                               const std::string& place) const {
  const size_t across = tiles_across(info_.width);
  if (tiles_.size() != across * tiles_across(info_.height)) corrupt(place, "tiles are missing");
  uint64_t end = sizeof(CacheHeader);
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const TileEntry entry = read_entry(directory, i);
    const auto x0 = static_cast<int>(i % across) * tile_size;
    const auto y0 = static_cast<int>(i / across) * tile_size;
    if (entry.x0 != x0 || entry.y0 != y0 || entry.width != std::min(tile_size, info_.width - x0) ||
        entry.height != std::min(tile_size, info_.height - y0)) {
      corrupt(place, "a tile is not where it belongs in the image");
    }
    if (entry.offset < end || !inside(entry.offset, entry.size, bytes_.size())) {
      corrupt(place, "a tile lies outside the file or within another");
    }
    end = entry.offset + entry.size;
    if (entry.footprint_offset % 64 != 0 ||
        !inside(entry.footprint_offset, entry.footprint_size, bytes_.size())) {
      corrupt(place, "a tile's footprints lie outside the file");
    }
  }
}

PackedTile RelightCache::check_tile(const TileEntry& entry, const std::string& place) const {
  const uint64_t pixels = uint64_t{entry.width} * entry.height;
  const uint64_t floats =
      pixels * ((info_.has_predicted_error ? 1 : 0) + (info_.has_emission ? 3 : 0));
  const uint64_t pixel_bytes =
      floats > 0 ? coverage_stride(pixels) + floats * sizeof(float) : pixels;
  const size_t stride = block_stride(info_.types.size(), info_.format);
  if (entry.offset % 64 != 0 || entry.data_words > entry.size / sizeof(uint32_t) ||
      entry.block_count > max_tile_blocks ||
      !inside(entry.data_words * sizeof(uint32_t), entry.block_count * stride + pixel_bytes,
              entry.size)) {
    corrupt(place, "a tile's parts do not fit into it");
  }
  const std::byte* start = bytes_.data() + entry.offset;
  if (hash_bytes({start, entry.size}) != entry.hash) corrupt(place, "a checksum does not match");
  PackedTile tile{entry.x0, entry.y0, entry.width, entry.height,
                  static_cast<int>(entry.block_count)};
  tile.words = reinterpret_cast<const uint32_t*>(start);
  tile.blocks = start + entry.data_words * sizeof(uint32_t);
  tile.coverage = reinterpret_cast<const uint8_t*>(tile.blocks + entry.block_count * stride);
  if (info_.has_predicted_error) {
    tile.predicted_error = reinterpret_cast<const float*>(tile.coverage + coverage_stride(pixels));
    for (uint64_t i = 0; i < pixels; ++i) {
      const float error = tile.predicted_error[i];
      if (!is_finite(error) || !(error >= 0) || (error > 0 && tile.coverage[i] == 0)) {
        corrupt(place, "a predicted error is not valid");
      }
    }
  }
  if (info_.has_emission) {
    const auto* const first =
        reinterpret_cast<const float*>(tile.coverage + coverage_stride(pixels));
    tile.emission = first + (info_.has_predicted_error ? pixels : 0);
    const std::span values(tile.emission, 3 * pixels);
    const auto is_radiance = [](float x) { return x >= 0 && x <= 2 * max_emission; };
    if (!std::ranges::all_of(values, is_radiance)) corrupt(place, "an emission is not valid");
  }
  for (int b = 0; b < tile.block_count; ++b) {
    uint32_t first_word = 0;
    std::memcpy(&first_word, tile.blocks + b * stride, sizeof(first_word));
    uint64_t words = 0;
    const PackedBlock header = block(tile, b);
    for (size_t t = 0; t < info_.types.size(); ++t) {
      if (header.slots[t] > max_slots) corrupt(place, "a block has too many slots");
      words += uint64_t{header.slots[t]} * layouts_[t].words * block_lanes;
    }
    bool ok = header.lanes >= 1 && header.lanes <= block_lanes && first_word % block_lanes == 0 &&
              inside(first_word, words, entry.data_words) &&
              (header.frame == nullptr || is_frame(header.frame, info_.types.size()));
    for (int lane = 0; lane < block_lanes; ++lane) {
      ok = ok && header.pixels[lane] % tile_size < entry.width &&
           header.pixels[lane] / tile_size < entry.height;
    }
    if (!ok) corrupt(place, "a block lies outside its tile");
  }
  if (info_.has_footprints) check_footprints(entry, tile, place);
  return tile;
}

void RelightCache::check_footprints(const TileEntry& entry, PackedTile& tile,
                                    const std::string& place) const {
  const std::byte* start = bytes_.data() + entry.footprint_offset;
  if (hash_bytes({start, entry.footprint_size}) != entry.footprint_hash) {
    corrupt(place, "a checksum does not match");
  }
  const uint64_t slots = slots_of(tile);
  uint64_t end = 0;
  const auto take = [&](uint64_t size) {
    if (!inside(end, size, entry.footprint_size)) {
      corrupt(place, "a tile's footprints do not fit into their part");
    }
    const std::byte* part = start + end;
    end += size;
    return part;
  };
  tile.footprints = reinterpret_cast<const uint32_t*>(take(slots * footprint_slot_bytes));
  if (!info_.has_members) return;
  tile.member_counts = reinterpret_cast<const uint8_t*>(take(slots * block_lanes));
  uint64_t members = 0;
  for (uint64_t i = 0; i < slots * block_lanes; ++i) members += tile.member_counts[i];
  tile.members = reinterpret_cast<const PackedMember*>(take(members * sizeof(PackedMember)));
}

uint64_t RelightCache::slots_of(const PackedTile& tile) const {
  uint64_t slots = 0;
  for (int b = 0; b < tile.block_count; ++b) {
    const PackedBlock packed = block(tile, b);
    for (size_t t = 0; t < info_.types.size(); ++t) slots += packed.slots[t];
  }
  return slots;
}

void RelightCache::parse(std::span<const ShaderInfo* const> shaders, const std::string& place) {
  const CacheHeader header = read_header(bytes_, place);
  bytes_ = bytes_.first(header.file_size);
  const auto info = bytes_.subspan(header.info_offset, header.info_size);
  const auto directory =
      bytes_.subspan(header.directory_offset, header.tile_count * sizeof(TileEntry));
  if (index_hash(header, info, directory) != header.index_hash) {
    corrupt(place, "the index checksum does not match");
  }
  info_ = decode_info(info, shaders, place);
  view_axes_ = make_view_axes(info_.camera);
  for (const SampleType& type : info_.types) {
    layouts_.push_back(make_record_layout(type.shader->fields, info_.format));
  }
  block_stride_ = block_stride(info_.types.size(), info_.format);
  if (info_.format != CacheFormat::exact) frame_offset_ = block_frame_offset(info_.types.size());
  tiles_.resize(header.tile_count);
  check_order(directory, place);
  parallel_for(header.tile_count, 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      tiles_[i] = check_tile(read_entry(directory, i), place);
    }
  });
  for (PackedTile& tile : tiles_) {
    tile.first_slot = slot_count_;
    slot_count_ += slots_of(tile);
  }
}

int RelightCache::block_count(const PackedTile& tile, PixelShare share) const {
  const auto share_of = [&](int index) {
    const int pixel = block(tile, index).pixels[0];
    return first_share_of(tile.x0 + pixel % tile_size, tile.y0 + pixel / tile_size);
  };
  int count = share == PixelShare::none ? 0 : tile.block_count;
  while (count > 0 && share_of(count - 1) > share) --count;
  return count;
}

uint64_t RelightCache::hash() const {
  CacheHeader header;
  std::memcpy(&header, bytes_.data(), sizeof(header));
  return header.index_hash;  // the directory holds the hashes of all chunks
}

size_t RelightCache::shading_bytes() const {
  size_t size = 0;
  for (const PackedTile& tile : tiles_) {
    size += tile.coverage - reinterpret_cast<const uint8_t*>(tile.words);
  }
  return size;
}

std::vector<float> RelightCache::coverage() const {
  return gather(info_, tiles_, [](const PackedTile& tile, int pixel) {
    return static_cast<float>(tile.coverage[pixel]) / 255.0f;
  });
}

std::vector<float> RelightCache::predicted_error() const {
  if (!info_.has_predicted_error) return {};
  return gather(info_, tiles_,
                [](const PackedTile& tile, int pixel) { return tile.predicted_error[pixel]; });
}

std::vector<float> RelightCache::emission() const {
  if (!info_.has_emission) return {};
  std::vector<float> result(3 * static_cast<size_t>(info_.width) * info_.height);
  for (const PackedTile& tile : tiles_) {
    for (int y = 0; y < tile.height; ++y) {
      const size_t first = static_cast<size_t>(tile.y0 + y) * info_.width + tile.x0;
      std::copy_n(tile.emission + size_t{3} * y * tile.width, 3 * tile.width,
                  result.begin() + static_cast<std::ptrdiff_t>(3 * first));
    }
  }
  return result;
}

std::vector<float> RelightCache::record_counts() const {
  std::vector<float> counts(static_cast<size_t>(info_.width) * info_.height);
  for (const PackedTile& tile : tiles_) {
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock packed = block(tile, b);
      const uint32_t* words = packed.words;
      for (size_t t = 0; t < info_.types.size(); ++t) {
        for (int slot = 0; slot < packed.slots[t]; ++slot) {
          for (int lane = 0; lane < packed.lanes; ++lane) {
            const int x = tile.x0 + packed.pixels[lane] % tile_size;
            const int y = tile.y0 + packed.pixels[lane] / tile_size;
            const bool present = is_present(layouts_[t], words + lane);
            counts[static_cast<size_t>(y) * info_.width + x] += present ? 1.0f : 0.0f;
          }
          words += static_cast<size_t>(layouts_[t].words) * block_lanes;
        }
      }
    }
  }
  return counts;
}

}  // namespace relume

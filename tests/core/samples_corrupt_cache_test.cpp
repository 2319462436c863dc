#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "core/relight/receivers.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

using Bytes = std::vector<std::byte>;

/// Gives each record a footprint, and every second two stored members.
void fill_footprints(SampleTile& tile) {
  tile.has_footprints = true;
  tile.has_members = true;
  for (TypedRows& rows : tile.types) {
    rows.footprints.assign(rows.rows(), Footprint());
    for (size_t row = 0; row < rows.rows(); row += 2) {
      Footprint& footprint = rows.footprints[row];
      footprint.samples = 5;
      footprint.covariance = {1, 0, 0, 1, 0, 0};
      footprint.stored_members = 2;
      rows.members.insert(rows.members.end(), 2, Member());
    }
  }
}

/// A valid cache of two tiles with predicted errors, footprints and members.
Bytes make_valid() {
  const std::vector<SampleType> types = all_sample_types();
  CacheWriter writer;
  SampleTile left = make_random_tile(types, 16, 5, 2, 1);
  SampleTile right = make_random_tile(types, 3, 5, 2, 2);
  right.x0 = 16;
  fill_predicted_error(left);
  fill_predicted_error(right);
  fill_footprints(left);
  fill_footprints(right);
  writer.add(pack_tile(left, types));
  writer.add(pack_tile(right, types));
  CacheInfo info = make_tile_info(left, types, {0, 0, 5});
  info.width = 19;
  info.lights = {make_point_light({0, 1, 2})};
  info.scene_text = "{}";
  writer.finish(info);
  const CacheBytes chunks = writer.take_bytes();
  const auto all = std::as_bytes(std::span(chunks));
  CacheHeader header;
  std::memcpy(&header, all.data(), sizeof(header));
  return {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(header.file_size)};
}

CacheBytes to_chunks(const Bytes& bytes) {
  CacheBytes chunks((bytes.size() + 63) / 64);
  if (!bytes.empty()) std::memcpy(chunks.data(), bytes.data(), bytes.size());
  return chunks;
}

/// Opens and looks at everything; the cache must be sound if it opens.
void use(const Bytes& bytes) {
  const RelightCache cache = RelightCache::from_bytes(to_chunks(bytes), shader_table(), "evil");
  volatile float sum = 0;
  for (const PackedTile& tile : cache.tiles()) {
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      size_t floats = 0;
      for (size_t t = 0; t < cache.info().types.size(); ++t) {
        floats += static_cast<size_t>(block.slots[t]) * (1 + cache.info().types[t].width) * 16;
      }
      for (size_t i = 0; i < floats; ++i) sum = sum + block.floats()[i];
    }
  }
  sum = sum + static_cast<float>(cache.coverage().size());
  for (const float count : cache.record_counts()) sum = sum + count;
  for (const float error : cache.predicted_error()) {
    EXPECT_TRUE(is_finite(error) && error >= 0) << error;
  }
  const ViewReceivers view(cache);
  for (size_t t = 0; t < view.tile_count(); ++t) {
    view.visit_tile(t, [&](const ReceiverGroup& group) {
      for (const Footprint& footprint : group.footprints) EXPECT_TRUE(is_finite(footprint.offset));
      for (const Member& member : group.members) sum = sum + member.offset.x;
    });
  }
}

::testing::AssertionResult is_refused(const Bytes& bytes) {
  try {
    use(bytes);
  } catch (const Error& error) {
    const bool right = error.kind() == ErrorKind::input || error.kind() == ErrorKind::limit;
    const bool placed = std::string(error.what()).starts_with("evil");
    if (right && placed) return ::testing::AssertionSuccess();
    return ::testing::AssertionFailure() << "wrong error: " << error.what();
  } catch (const std::exception& error) {
    return ::testing::AssertionFailure() << "not an Error: " << error.what();
  }
  return ::testing::AssertionFailure() << "was accepted";
}

/// Gives the index the hash that fits it, as a forger would.
void rehash(Bytes& bytes) {
  CacheHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  const auto inside = [&](uint64_t offset, uint64_t size) {
    return offset <= bytes.size() && size <= bytes.size() - offset;
  };
  const uint64_t directory_size = header.tile_count * sizeof(TileEntry);
  if (header.tile_count > bytes.size() || !inside(header.info_offset, header.info_size) ||
      !inside(header.directory_offset, directory_size)) {
    return;
  }
  const std::span<const std::byte> all(bytes);
  header.index_hash = index_hash(header, all.subspan(header.info_offset, header.info_size),
                                 all.subspan(header.directory_offset, directory_size));
  std::memcpy(bytes.data(), &header, sizeof(header));
}

TEST(CorruptCache, ValidBytesOpen) {
  EXPECT_NO_THROW(use(make_valid()));
}

TEST(CorruptCache, EveryTruncationIsRefused) {
  const Bytes valid = make_valid();
  for (size_t length = 0; length < valid.size(); length += length < 256 ? 1 : 37) {
    const Bytes cut(valid.begin(), valid.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_TRUE(is_refused(cut)) << "cut to " << length << " of " << valid.size();
  }
  // Chunks in memory are padded, files are exact.
  const TemporaryFolder folder;
  for (const size_t cut : {size_t{1}, size_t{2}, size_t{63}, valid.size() - 1, valid.size()}) {
    write_all(folder.file("cut"),
              {reinterpret_cast<const char*>(valid.data()), valid.size() - cut});
    EXPECT_ERROR(RelightCache::open(folder.file("cut"), shader_table()), ErrorKind::input, "cut");
  }
}

TEST(CorruptCache, EveryFlippedByteIsRefused) {
  const Bytes valid = make_valid();
  for (size_t i = 0; i < valid.size(); i += i < 128 || i > valid.size() - 1500 ? 1 : 61) {
    Bytes flipped = valid;
    flipped[i] ^= std::byte{0x10};
    EXPECT_TRUE(is_refused(flipped)) << "byte " << i << " of " << valid.size();
  }
}

TEST(CorruptCache, OtherVersionByteOrderAndMagicAreNamed) {
  Bytes bytes = make_valid();
  bytes[8] = std::byte{1};
  EXPECT_ERROR(use(bytes), ErrorKind::input,
               fmt::format("has cache version 1, not {}", cache_version));
  bytes = make_valid();
  bytes[0] = std::byte{'X'};
  EXPECT_ERROR(use(bytes), ErrorKind::input, "not a .relume cache");
  bytes = make_valid();
  std::swap(bytes[12], bytes[15]);
  EXPECT_TRUE(is_refused(bytes));
}

TEST(CorruptCache, ForgedHeaderNumbersAreRefused) {
  const Bytes valid = make_valid();
  for (size_t field = 16; field < 56; field += 8) {
    for (const uint64_t value : {uint64_t{0}, uint64_t{1}, uint64_t{63}, uint64_t{valid.size()},
                                 uint64_t{valid.size() + 64}, uint64_t{1} << 32, uint64_t{1} << 63,
                                 ~uint64_t{0}, ~uint64_t{0} / 48 + 1}) {
      Bytes forged = valid;
      std::memcpy(&forged[field], &value, sizeof(value));
      if (forged == valid) continue;
      rehash(forged);
      EXPECT_TRUE(is_refused(forged)) << "field at " << field << " = " << value;
    }
  }
}

void forge_entry(Bytes& bytes, size_t tile, const std::function<void(TileEntry&)>& change) {
  CacheHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  TileEntry entry;
  std::byte* at = &bytes[header.directory_offset + tile * sizeof(entry)];
  std::memcpy(&entry, at, sizeof(entry));
  change(entry);
  if (entry.offset <= bytes.size() && entry.size <= bytes.size() - entry.offset) {
    entry.hash = hash_bytes(std::span(bytes).subspan(entry.offset, entry.size));
  }
  if (entry.footprint_offset <= bytes.size() &&
      entry.footprint_size <= bytes.size() - entry.footprint_offset) {
    entry.footprint_hash =
        hash_bytes(std::span(bytes).subspan(entry.footprint_offset, entry.footprint_size));
  }
  std::memcpy(at, &entry, sizeof(entry));
  rehash(bytes);
}

TEST(CorruptCache, ForgedTilesAreRefused) {
  const uint64_t huge = ~uint64_t{0};
  const std::vector<std::function<void(TileEntry&)>> changes = {
      [](TileEntry& e) { e.x0 = 65535; },
      [](TileEntry& e) { e.x0 = 0; },
      [](TileEntry& e) { e.y0 = 1; },
      [](TileEntry& e) { e.width = 0; },
      [](TileEntry& e) { e.width = 2; },
      [](TileEntry& e) { e.width = 17; },
      [](TileEntry& e) { e.height = 65535; },
      [](TileEntry& e) { e.block_count = 0xffffffff; },
      [](TileEntry& e) { e.block_count = 200; },
      [=](TileEntry& e) { e.offset = huge; },
      [=](TileEntry& e) { e.offset = huge - 63; },
      [](TileEntry& e) { e.offset += 4; },
      [](TileEntry& e) { e.offset = 64; },  // the first tile's chunk
      [=](TileEntry& e) { e.size = huge; },
      [](TileEntry& e) { e.size = 0; },
      [=](TileEntry& e) { e.data_words = huge; },
      [=](TileEntry& e) { e.data_words = huge / 4 + 2; },
      [](TileEntry& e) { e.data_words += 1; },
      [](TileEntry& e) { e.data_words = e.size / 4; },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    Bytes forged = make_valid();
    forge_entry(forged, 1, changes[i]);
    EXPECT_TRUE(is_refused(forged)) << "change " << i;
  }
}

TEST(CorruptCache, ForgedBlocksNeverReadOutside) {
  // Any byte of the block headers may be anything: refused, or sound (the sanitizer build sees to
  // it).
  const Bytes valid = make_valid();
  CacheHeader header;
  std::memcpy(&header, valid.data(), sizeof(header));
  TileEntry entry;
  std::memcpy(&entry, &valid[header.directory_offset], sizeof(entry));
  const size_t begin = entry.offset + entry.data_words * sizeof(float);
  const size_t end =
      begin + entry.block_count * block_stride(all_sample_types().size(), CacheFormat::exact);
  int refused = 0;
  for (size_t i = begin; i < end; ++i) {
    Bytes forged = valid;
    forged[i] = std::byte{0xff};
    forge_entry(forged, 0, [](TileEntry&) {});
    try {
      use(forged);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      ++refused;
    }
  }
  EXPECT_GT(refused, 50);
}

/// Where the first tile's coverage bytes start.
size_t coverage_offset(const Bytes& bytes) {
  CacheHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  TileEntry entry;
  std::memcpy(&entry, &bytes[header.directory_offset], sizeof(entry));
  return entry.offset + entry.data_words * sizeof(float) +
         entry.block_count * block_stride(all_sample_types().size(), CacheFormat::exact);
}

TEST(CorruptCache, ForgedPredictedErrorsAreRefused) {
  const Bytes valid = make_valid();
  const size_t coverage = coverage_offset(valid);
  const size_t errors = coverage + coverage_stride(16 * 5);
  const float infinity = std::numeric_limits<float>::infinity();
  for (const size_t pixel : {size_t{0}, size_t{79}}) {
    for (const float value : {-1e-30f, -1.0f, infinity, -infinity, std::nanf("")}) {
      Bytes forged = valid;
      std::memcpy(&forged[errors + pixel * sizeof(float)], &value, sizeof(value));
      forge_entry(forged, 0, [](TileEntry&) {});
      EXPECT_ERROR(use(forged), ErrorKind::input, "a predicted error is not valid");
    }
    Bytes forged = valid;
    const float value = 7;
    std::memcpy(&forged[errors + pixel * sizeof(float)], &value, sizeof(value));
    forged[coverage + pixel] = std::byte{1};
    forge_entry(forged, 0, [](TileEntry&) {});
    EXPECT_NO_THROW(use(forged));
    forged[coverage + pixel] = std::byte{0};
    forge_entry(forged, 0, [](TileEntry&) {});
    EXPECT_ERROR(use(forged), ErrorKind::input, "a predicted error is not valid");
  }
}

TEST(CorruptCache, TilesWithoutRoomForPredictedErrorsAreRefused) {
  const Bytes valid = make_valid();
  // The first tile's parts end 80 coverage bytes and 80 floats after its blocks.
  const size_t begin = coverage_offset(valid);
  for (const size_t kept : {size_t{80 + 320 - 1}, size_t{80 + 4}, size_t{80}, size_t{79}}) {
    Bytes forged = valid;
    forge_entry(forged, 0, [&](TileEntry& e) { e.size = begin + kept - e.offset; });
    EXPECT_ERROR(use(forged), ErrorKind::input, "a tile's parts do not fit into it");
  }
}

TileEntry first_entry(const Bytes& bytes) {
  CacheHeader header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  TileEntry entry;
  std::memcpy(&entry, &bytes[header.directory_offset], sizeof(entry));
  return entry;
}

TEST(CorruptCache, TilesWithoutRoomForFootprintsAreRefused) {
  const Bytes valid = make_valid();
  const RelightCache cache = RelightCache::from_bytes(to_chunks(valid), shader_table(), "evil");
  const auto slots = static_cast<size_t>(cache.tiles()[1].first_slot);
  const size_t footprints = first_entry(valid).footprint_offset;
  const size_t counts = footprints + slots * footprint_slot_bytes;
  size_t members = 0;
  for (size_t i = 0; i < slots * block_lanes; ++i)
    members += static_cast<size_t>(valid[counts + i]);
  ASSERT_GT(members, 0u);
  const size_t end = counts + slots * block_lanes + members * sizeof(PackedMember);
  const char* const message = "a tile's footprints do not fit into their part";
  for (const size_t kept :
       {footprints, footprints + 1, counts - 1, counts, counts + slots * block_lanes, end - 1}) {
    Bytes forged = valid;
    forge_entry(forged, 0, [&](TileEntry& e) { e.footprint_size = kept - footprints; });
    EXPECT_ERROR(use(forged), ErrorKind::input, message);
  }
  Bytes exact = valid;
  forge_entry(exact, 0, [&](TileEntry& e) { e.footprint_size = end - footprints; });
  EXPECT_NO_THROW(use(exact));
  // More members than there is room for.
  Bytes forged = valid;
  forged[counts] = std::byte{255};
  forge_entry(forged, 0, [](TileEntry&) {});
  EXPECT_ERROR(use(forged), ErrorKind::input, message);
}

TEST(CorruptCache, FootprintsOutsideTheFileAreRefused) {
  const Bytes valid = make_valid();
  for (const uint64_t value : {uint64_t{1}, uint64_t{64} << 40, ~uint64_t{0}}) {
    Bytes moved = valid;
    forge_entry(moved, 0, [&](TileEntry& e) { e.footprint_offset = value; });
    EXPECT_TRUE(is_refused(moved)) << value;
    Bytes longer = valid;
    forge_entry(longer, 0, [&](TileEntry& e) { e.footprint_size = value << 8; });
    EXPECT_TRUE(is_refused(longer)) << value;
  }
  Bytes changed = valid;
  changed[first_entry(valid).footprint_offset] ^= std::byte{1};
  EXPECT_ERROR(use(changed), ErrorKind::input, "checksum");
}

TEST(CorruptCache, AnyFootprintBitsAreSound) {
  const Bytes valid = make_valid();
  const size_t footprints = first_entry(valid).footprint_offset;
  for (const int value : {0x00, 0x7f, 0x80, 0xff}) {
    Bytes forged = valid;
    std::fill_n(&forged[footprints], footprint_slot_bytes, static_cast<std::byte>(value));
    forge_entry(forged, 0, [](TileEntry&) {});
    EXPECT_NO_THROW(use(forged));
  }
}

TEST(CorruptCache, PredictedErrorsThatWereNeverWrittenAreRefused) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 16, 16, 0, 1);
  CacheWriter writer;
  writer.add(pack_tile(tile, types));
  CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
  writer.finish(info);
  const CacheBytes chunks = writer.take_bytes();
  const auto all = std::as_bytes(std::span(chunks));
  Bytes forged(all.begin(), all.end());
  EXPECT_NO_THROW(use(forged));
  CacheHeader header;
  std::memcpy(&header, forged.data(), sizeof(header));
  info.has_predicted_error = true;
  const std::vector<std::byte> encoded = encode_info(info);
  ASSERT_EQ(encoded.size(), header.info_size);
  std::copy(encoded.begin(), encoded.end(),
            forged.begin() + static_cast<std::ptrdiff_t>(header.info_offset));
  rehash(forged);
  EXPECT_ERROR(use(forged), ErrorKind::input, "a tile's parts do not fit into it");
}

TEST(CorruptCache, ForgedInfoBytesNeverCrash) {
  const Bytes valid = make_valid();
  CacheHeader header;
  std::memcpy(&header, valid.data(), sizeof(header));
  for (const int value : {0x00, 0x7f, 0x80, 0xff}) {
    for (size_t i = 0; i < header.info_size; ++i) {
      Bytes forged = valid;
      forged[header.info_offset + i] = static_cast<std::byte>(value);
      rehash(forged);
      try {
        use(forged);
      } catch (const Error& error) {
        EXPECT_TRUE(error.kind() == ErrorKind::input || error.kind() == ErrorKind::limit);
      }
    }
  }
}

TEST(CorruptCache, FlagsAreZeroOrOne) {
  const Bytes valid = make_valid();
  CacheHeader header;
  std::memcpy(&header, valid.data(), sizeof(header));
  const CacheInfo info = RelightCache::from_bytes(to_chunks(valid), shader_table(), "evil").info();
  const std::vector<std::byte> encoded = encode_info(info);
  ASSERT_EQ(encoded.size(), header.info_size);
  const std::vector<bool CacheInfo::*> flags = {&CacheInfo::has_predicted_error,
                                                &CacheInfo::has_footprints, &CacheInfo::has_members,
                                                &CacheInfo::has_emission};
  for (size_t i = 0; i < flags.size(); ++i) {
    CacheInfo other = info;
    other.*flags[i] = !(other.*flags[i]);
    const std::vector<std::byte> changed = encode_info(other);
    const auto at = std::mismatch(encoded.begin(), encoded.end(), changed.begin()).first;
    Bytes forged = valid;
    forged[header.info_offset + static_cast<size_t>(at - encoded.begin())] = std::byte{2};
    rehash(forged);
    EXPECT_ERROR(use(forged), ErrorKind::input, "a label is unknown");
  }
}

TEST(CorruptCache, ImageMustMatchTheTiles) {
  // A small file may not claim a large image: the reader would allocate it.
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 4, 4, 1, 1);
  for (const ivec2 size : {ivec2(16384, 16384), ivec2(17, 4), ivec2(4, 5), ivec2(3, 4)}) {
    CacheWriter writer;
    writer.add(pack_tile(tile, types));
    CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
    info.width = size.x;
    info.height = size.y;
    writer.finish(info);
    EXPECT_ERROR(RelightCache::from_bytes(writer.take_bytes(), shader_table(), "evil"),
                 ErrorKind::input, "tile");
  }
}

TEST(CorruptCache, InfoThatMakesNoSenseIsRefused) {
  const float nan = std::nanf("");
  const std::vector<std::function<void(CacheInfo&)>> changes = {
      [](CacheInfo& i) { i.width = 0; },
      [](CacheInfo& i) { i.height = 16385; },
      [](CacheInfo& i) { i.height = -1; },
      [=](CacheInfo& i) { i.camera.eye.x = nan; },
      [](CacheInfo& i) { i.camera.target = i.camera.eye; },
      [](CacheInfo& i) { i.camera.fov_y_deg = 180; },
      [=](CacheInfo& i) { i.bounds.low.x = nan; },
      [=](CacheInfo& i) { i.bounds.high.z = nan; },
      [](CacheInfo& i) { i.bounds.high.x = std::numeric_limits<float>::infinity(); },
      [](CacheInfo& i) { i.bounds.high.y = i.bounds.low.y - 1; },
      [=](CacheInfo& i) { i.exposure = nan; },
      [=](CacheInfo& i) { i.average_records = nan; },
      [](CacheInfo& i) { i.average_records = -1; },
      [](CacheInfo& i) { i.target_error = std::numeric_limits<float>::infinity(); },
      [](CacheInfo& i) { i.target_error = -1e-30f; },
      [=](CacheInfo& i) { i.lights = {make_point_light(vec3(nan))}; },
      [=](CacheInfo& i) { i.representative_low.position.x = nan; },
      [](CacheInfo& i) { i.representative_high.direction = vec3(0); },
      [](CacheInfo& i) { i.lights.assign(1025, Light()); },
      [](CacheInfo& i) { i.types.assign(65, i.types[0]); },
  };
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 4, 4, 0, 1);
  for (size_t i = 0; i < changes.size(); ++i) {
    CacheWriter writer;
    writer.add(pack_tile(tile, types));
    CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
    changes[i](info);
    writer.finish(info);
    const CacheBytes chunks = writer.take_bytes();
    const auto bytes = std::as_bytes(std::span(chunks));
    EXPECT_TRUE(is_refused({bytes.begin(), bytes.end()})) << "change " << i;
  }
}

TEST(CorruptCache, ImagesBeyondTheLimitAreToldAsSuch) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 4, 4, 0, 1);
  for (const ivec2 size : {ivec2(0, 4), ivec2(4, -1), ivec2(16385, 4), ivec2(4, 16385)}) {
    CacheWriter writer;
    writer.add(pack_tile(tile, types));
    CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
    info.width = size.x;
    info.height = size.y;
    writer.finish(info);
    EXPECT_ERROR(RelightCache::from_bytes(writer.take_bytes(), shader_table(), "evil"),
                 ErrorKind::input, "the image size is out of range");
  }
}

TEST(CorruptCache, UnknownShaderIsNamed) {
  const auto all = shader_table();
  const Bytes valid = make_valid();
  EXPECT_ERROR(RelightCache::from_bytes(to_chunks(valid), all.first(1), "evil"), ErrorKind::input,
               "unknown shader phong");
}

}  // namespace
}  // namespace relume

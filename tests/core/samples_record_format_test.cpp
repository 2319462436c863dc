#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/relight/block_decoder.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/samples/record_encode.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

constexpr CacheFormat packed_formats[] = {CacheFormat::standard, CacheFormat::compact};

TEST(RecordLayout, TakesTheBytesItPromises) {
  const auto bytes = [](const char* shader, CacheFormat format) {
    for (const ShaderInfo* info : shader_table()) {
      if (info->name == shader) return 4 * make_record_layout(info->fields, format).words;
    }
    return -1;
  };
  EXPECT_EQ(bytes("phong", CacheFormat::exact), 60);
  EXPECT_EQ(bytes("phong", CacheFormat::standard), 20);
  EXPECT_EQ(bytes("phong", CacheFormat::compact), 16);
  EXPECT_EQ(bytes("kajiya-kay", CacheFormat::standard), 20);
  EXPECT_EQ(bytes("kajiya-kay", CacheFormat::compact), 16);
  EXPECT_EQ(bytes("ggx", CacheFormat::exact), 64);
  EXPECT_EQ(bytes("ggx", CacheFormat::standard), 24);
  EXPECT_EQ(bytes("ggx", CacheFormat::compact), 20);
  EXPECT_EQ(bytes("leaf", CacheFormat::standard), 20);
  EXPECT_EQ(bytes("leaf", CacheFormat::compact), 16);
  EXPECT_EQ(bytes("lambert", CacheFormat::standard), 16);
  EXPECT_EQ(bytes("lambert", CacheFormat::compact), 12);
}

TEST(RecordLayout, GivesEveryBitToOneComponent) {
  // Widths, kinds and numbers of fields that no shader has.
  const SampleField odd[] = {
      position_field_info,
      bias_field_info,
      {"a", 3, FieldKind::direction, FieldSource::normal, "1", Merge::average},
      {"b", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 10, 1},
      {"c", 1, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 1},
      {"d", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 1},
      {"e", 3, FieldKind::axis, FieldSource::tangent, "1", Merge::average},
      {"f", 3, FieldKind::scalar, FieldSource::material, "1", Merge::average, -1, 1, 0},
  };
  std::vector<std::span<const SampleField>> declarations{odd};
  for (const ShaderInfo* info : shader_table()) declarations.push_back(info->fields);
  for (const auto& fields : declarations) {
    for (const auto& [format, name] : cache_format_labels) {
      const RecordLayout layout = make_record_layout(fields, format);
      std::vector<uint32_t> used(layout.words);
      if (format == CacheFormat::exact) used[0] = ~0u;  // the weight
      int floats = 0;
      for (int f = 0; f < layout.field_count; ++f) {
        const PackedField& field = layout.fields[f];
        EXPECT_EQ(field.first, floats);
        floats += field.width;
        for (int i = 0; i < 3; ++i) {
          if (field.bits[i] == 0) continue;
          ASSERT_LE(field.shift[i] + field.bits[i], 32);
          const auto mask =
              static_cast<uint32_t>(((uint64_t{1} << field.bits[i]) - 1) << field.shift[i]);
          EXPECT_EQ(used.at(field.word[i]) & mask, 0u) << name << " field " << f;
          used[field.word[i]] |= mask;
        }
      }
      EXPECT_EQ(layout.width, floats);
      for (const uint32_t word : used) EXPECT_NE(word, 0u);
    }
  }
}

/// One tile of one type, one record a pixel of weight 1 / (1 + pixel % 30).
SampleTile make_weighted_tile(const SampleType& type, uint64_t seed) {
  SampleTile tile;
  tile.width = tile_size;
  tile.height = tile_size;
  tile.types.resize(1);
  tile.types[0].first.push_back(0);
  for (uint32_t pixel = 0; pixel < 256; ++pixel) {
    Random random(seed, RandomStream::tests, pixel);
    append_random_vector(type, random, tile.types[0].values);
    tile.types[0].values[3] = std::ldexp(random.uniform(1, 2), static_cast<int>(pixel % 40) - 30);
    tile.types[0].weights.push_back(1.0f / static_cast<float>(1 + pixel % 30));
    tile.types[0].first.push_back(pixel + 1);
  }
  return tile;
}

RelightCache make_format_cache(const SampleTile& tile, const std::vector<SampleType>& types,
                               CacheFormat format) {
  CacheWriter writer;
  const CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
  writer.add(pack_tile(tile, types, {format, info.camera}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

vec3 vector_at(const float* v, int first) {
  return {v[first], v[first + 1], v[first + 2]};
}

/// Each decoded record beside what went in.
template <class Check>
void for_each_record(const RelightCache& cache, const SampleTile& tile, const SampleType& type,
                     const Check& check) {
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  std::vector<float> scratch;
  const PackedTile& packed = cache.tiles()[0];
  int seen = 0;
  for (int b = 0; b < packed.block_count; ++b) {
    const PackedBlock block = cache.block(packed, b);
    const float* records = decoder.floats(block, scratch);
    for (int lane = 0; lane < block.lanes; ++lane) {
      std::vector<float> decoded;
      for (int i = 0; i < type.width; ++i) decoded.push_back(records[(1 + i) * 16 + lane]);
      const size_t pixel = block.pixels[lane];
      ASSERT_GT(records[lane], 0) << "pixel " << pixel;
      check(block, pixel, &tile.types[0].values[pixel * type.width], decoded.data(),
            tile.types[0].weights[pixel] / records[lane]);
      ++seen;
    }
  }
  EXPECT_EQ(seen, 256);
}

class PackedFormat : public testing::TestWithParam<std::tuple<CacheFormat, size_t>> {
 protected:
  CacheFormat format_ = std::get<0>(GetParam());
  SampleType type_ = all_sample_types()[std::get<1>(GetParam())];
};

TEST_P(PackedFormat, KeepsEachFieldWithinItsStep) {
  const bool is_compact = format_ == CacheFormat::compact;
  const SampleTile tile = make_weighted_tile(type_, 3);
  const RelightCache cache = make_format_cache(tile, {type_}, format_);
  EXPECT_EQ(cache.info().format, format_);
  const double angle = !is_compact ? 6e-5 : type_.width >= 14 ? 8e-3 : 4e-3;
  for_each_record(
      cache, tile, type_,
      [&](const PackedBlock& block, size_t pixel, const float* in, const float* out, float weight) {
        SCOPED_TRACE(fmt::format("pixel {}", pixel));
        // At depths of 4 to 6 of a block that spans the unit ball.
        const float moved = glm::distance(vector_at(out, 0), vector_at(in, 0));
        EXPECT_LE(moved, is_compact ? 8e-3f : 5e-4f);
        // Shadow rays start beyond what rounding moved.
        EXPECT_GE(out[3], in[3] + 1.99f * moved - 1e-6f);
        if (is_compact) {
          EXPECT_EQ(out[3], block.frame[6]);
        } else {
          EXPECT_LE(out[3], 1.5f * (in[3] + 2.01f * moved + 1e-6f));
        }
        const vec3 direction = vector_at(out, 4);
        EXPECT_NEAR(glm::length(direction), 1, 1e-6);
        EXPECT_LE(glm::distance(direction, vector_at(in, 4)), angle);
        for (size_t f = 0; f < type_.field_count(); ++f) {
          const int at = type_.offsets[f];
          if (type_.field(f).kind == FieldKind::linear) {
            const vec3 color = weight * vector_at(in, at);
            EXPECT_LE(max_abs_component(vector_at(out, at) - color),
                      max_component(color) / 511 + 0x1p-29f);
          }
          if (type_.field(f).source == FieldSource::material && type_.field(f).width == 1) {
            EXPECT_NEAR(out[at], in[at], 0.034f * (1 + in[at]));
          }
        }
      });
}

TEST_P(PackedFormat, AllInstructionSetsDecodeAlike) {
  const SampleTile tile = make_weighted_tile(type_, 4);
  const RelightCache cache = make_format_cache(tile, {type_}, format_);
  const BlockDecoder scalar(cache, InstructionSet::scalar);
  std::vector<float> expected;
  std::vector<float> scratch;
  for (const auto& [set, name] : instruction_set_labels) {
    if (set == InstructionSet::automatic || !is_supported(set)) continue;
    const BlockDecoder decoder(cache, set);
    for (int b = 0; b < cache.tiles()[0].block_count; ++b) {
      const PackedBlock block = cache.block(cache.tiles()[0], b);
      const float* exact = scalar.floats(block, expected);
      const float* floats = decoder.floats(block, scratch);
      for (int i = 0; i < (1 + type_.width) * 16; ++i) {
        const int field = i / 16 - 1;
        const bool is_vector = field >= 0 && field < 7 && field != 3;
        ASSERT_NEAR(floats[i], exact[i], is_vector ? 1e-6 : 0) << name << " float " << field;
      }
    }
  }
}

TEST_P(PackedFormat, AnyBitsGiveFiniteNumbersAndUnitDirections) {
  const RecordLayout layout = make_record_layout(type_.shader->fields, format_);
  const float frame[block_frame_floats] = {-1, 1e6f, 1e-3f, 2e6f, 0, 8e9f};
  const ViewAxes axes = make_view_axes({{1, 2, 3}, {2, 4, 6}, {0, 1, 0}, 40});
  std::vector<uint32_t> words(static_cast<size_t>(layout.words) * 16 * 500);
  Random random(8, RandomStream::tests, 0);
  for (size_t i = 0; i < words.size(); ++i) {
    const uint32_t choice = random.below(8);
    words[i] = choice == 0   ? 0
               : choice == 1 ? ~0u
                             : random.below(65536) << 16 | random.below(65536);
  }
  std::vector<float> out(static_cast<size_t>(1 + type_.width) * 16 * 500);
  for (const auto& [set, name] : instruction_set_labels) {
    if (set == InstructionSet::automatic || !is_supported(set)) continue;
    block_kernels(set).decode_slots(
        {format_, static_cast<int>(std::get<1>(GetParam())), words.data(), frame, 0.5f, &axes, 500},
        out.data());
    for (size_t slot = 0; slot < 500; ++slot) {
      const float* first = &out[slot * (1 + type_.width) * 16];
      for (int lane = 0; lane < 16; ++lane) {
        for (int i = 0; i <= type_.width; ++i) ASSERT_TRUE(is_finite(first[i * 16 + lane])) << name;
        const auto at = [&](int i) { return first[(1 + i) * 16 + lane]; };
        ASSERT_NEAR(glm::length(vec3(at(4), at(5), at(6))), 1, 1e-6) << name;
        for (size_t f = 0; f < type_.field_count(); ++f) {
          if (type_.field(f).source != FieldSource::material) continue;
          ASSERT_GE(at(type_.offsets[f]), 0);
          ASSERT_LE(at(type_.offsets[f]), 1.001e5f);
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(FormatsAndShaders, PackedFormat,
                         testing::Combine(testing::ValuesIn(packed_formats),
                                          testing::Range(size_t{0}, shader_table().size())),
                         [](const auto& parameter) {
                           return fmt::format(
                               "{}{}", label_of(cache_format_labels, std::get<0>(parameter.param)),
                               std::get<1>(parameter.param));
                         });

TEST(PackedCache, CountsTheRecordsOfTheExactOne) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 16, 13, 3, 1);
  const RelightCache exact = make_format_cache(tile, types, CacheFormat::exact);
  for (const CacheFormat format : packed_formats) {
    const RelightCache cache = make_format_cache(tile, types, format);
    EXPECT_EQ(cache.record_counts(), exact.record_counts());
    EXPECT_EQ(cache.coverage(), exact.coverage());
    EXPECT_EQ(cache.info().record_count, exact.info().record_count);
    EXPECT_LT(cache.size_bytes(), exact.size_bytes() / 2);
  }
}

TEST(PackedCache, ShowsColoursAboveOneAndClampsHugeOnes) {
  const SampleType type = all_sample_types()[0];
  SampleTile tile = make_weighted_tile(type, 5);
  tile.types[0].weights.assign(256, 1.0f);
  float* color = &tile.types[0].values[7];
  color[0] = 100;
  color[1] = 1e30f;
  color[2] = 0;
  const RelightCache cache = make_format_cache(tile, {type}, CacheFormat::compact);
  for_each_record(cache, tile, type,
                  [](const PackedBlock&, size_t pixel, const float*, const float* out, float) {
                    if (pixel != 0) return;
                    EXPECT_EQ(out[7], 104);  // the brightest sets a step of 8
                    EXPECT_EQ(out[8], 4088);
                    EXPECT_EQ(out[9], 0);
                  });
}

TEST(PackedCache, FramesThatAreNotFiniteAreRefused) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 16, 16, 2, 1);
  const float infinity = std::numeric_limits<float>::infinity();
  for (const int i : {0, 2, 3, 5, 6}) {
    for (const float value : {infinity, std::nanf(""), -5e9f, i < 3 ? 5e9f : -1.0f}) {
      const CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
      PackedTileData packed = pack_tile(tile, types, {CacheFormat::standard, info.camera});
      std::memcpy(&packed.blocks[block_frame_offset(types.size()) + i * sizeof(float)], &value,
                  sizeof(value));
      CacheWriter writer;
      writer.add(packed);
      writer.finish(info);
      EXPECT_ERROR(RelightCache::from_bytes(writer.take_bytes(), shader_table(), "evil"),
                   ErrorKind::input, "a block lies outside");
    }
  }
}

/// Every set, every light kind, in passes of several lights: kernels against the double loop over
/// the same decoded records.
TEST(PackedCache, KernelsMatchTheReference) {
  const std::vector<SampleType> types = all_sample_types();
  SampleTile tile = make_random_tile(types, 16, 11, 5, 3);
  widen_highlights(types, tile);
  const std::vector<Light> lights = {make_point_light({1, 2, 3}),
                                     make_point_light({-1, 2, 3}),
                                     make_point_light({1, -2, 3}),
                                     make_point_light({1, 2, 3}, 1, false),
                                     make_directional_light({1, 0, -1}),
                                     make_spot_light({0, 2, 2}, {0, -1, -1}, 10, 40),
                                     make_spot_light({1, 2, 2}, {0, -1, -1}, 10, 40, false)};
  for (const CacheFormat format : packed_formats) {
    const RelightCache cache = make_format_cache(tile, types, format);
    for (const auto& [set, name] : instruction_set_labels) {
      if (!is_supported(set)) continue;
      RelightState state = make_relight_state(cache);
      relight(state, lights, nullptr, {set});
      for (size_t i = 0; i < lights.size(); ++i) {
        const Image exact = reference_layer(cache, lights[i], nullptr);
        float brightest = 0;
        for (const float value : exact.pixels) brightest = std::max(brightest, value);
        EXPECT_GT(brightest, 0);
        EXPECT_LE(max_difference(layer_image(state, i), exact), 2e-5f * brightest + 1e-7f)
            << name << " light " << i;
      }
    }
  }
}

}  // namespace
}  // namespace relume

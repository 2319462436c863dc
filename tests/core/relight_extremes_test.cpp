#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/relight/block_decoder.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/response_bound.h"
#include "tests/support/scenes.h"

// Lights, materials and pictures at the ends of what is permitted, on every instruction set and in
// every format, against the double reference.

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

const vec3 eye(0.5f, -1, 5);

/// One record a pixel of each exponent from 0 to 1e5, roughness and reflectance from 0 to 1,
/// colours from denormal to 1.
SampleTile make_extreme_tile(const SampleType& type) {
  constexpr float exponents[] = {0, 1e-30f, 0.5f, 1, 2, 100, 1e4f, 1e5f};
  constexpr float fractions[] = {0, 1e-30f, 0.02f, 0.1f, 0.3f, 0.7f, 1};
  constexpr float colors[] = {0, 1e-45f, 1e-40f, 1e-30f, 1e-8f, 1};
  SampleTile tile;
  tile.width = tile_size;
  tile.height = 5;
  TypedRows& rows = tile.types.emplace_back();
  rows.first.push_back(0);
  for (uint32_t pixel = 0; pixel < static_cast<uint32_t>(tile.pixel_count()); ++pixel) {
    Random random(3, RandomStream::tests, pixel);
    append_random_vector(type, random, rows.values);
    float* v = &rows.values[rows.values.size() - type.width];
    for (int i = 7; i < std::min(type.width, 13); ++i) {
      if (random.below(2) == 0) v[i] = colors[random.below(std::size(colors))];
    }
    if (type.width == 14) v[13] = exponents[random.below(std::size(exponents))];
    for (int i = 13; type.width == 15 && i < 15; ++i)
      v[i] = fractions[random.below(std::size(fractions))];
    rows.weights.push_back(1);
    rows.first.push_back(pixel + 1);
  }
  return tile;
}

RelightCache make_format_cache(std::span<const SampleTile> tiles,
                               const std::vector<SampleType>& types, CacheFormat format, int width,
                               int height) {
  CacheInfo info = make_tile_info(tiles[0], types, eye);
  info.width = width;
  info.height = height;
  CacheWriter writer;
  for (const SampleTile& tile : tiles) writer.add(pack_tile(tile, types, {format, info.camera}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

/// The record of each pixel of a cache of one tile, one type and one record a pixel, as stored;
/// empty where rounding left it without colour.
std::vector<std::vector<float>> stored_vectors(const RelightCache& cache) {
  const BlockDecoder decoder(cache, InstructionSet::scalar);
  const CacheInfo& info = cache.info();
  std::vector<std::vector<float>> vectors(static_cast<size_t>(info.width) * info.height);
  std::vector<float> scratch;
  for (int b = 0; b < cache.tiles()[0].block_count; ++b) {
    const PackedBlock block = cache.block(cache.tiles()[0], b);
    const float* records = decoder.floats(block, scratch);
    for (int lane = 0; lane < block.lanes; ++lane) {
      if (!(records[lane] > 0)) continue;
      for (int i = 0; i < info.types[0].width; ++i) {
        vectors[block.pixels[lane]].push_back(records[(1 + i) * block_lanes + lane]);
      }
    }
  }
  return vectors;
}

/// Lights of every kind at `position`, spots aimed at `target`.
void append_positional(vec3 position, vec3 target, std::vector<Light>& lights) {
  const vec3 aim = normalize_or(target - position, {0, 0, -1});
  for (const float part : {0.5f, 1.0f, 1.0001f, 3.0f}) {
    const float range = std::clamp(part * glm::distance(position, target), 1e-15f, 1e15f);
    lights.push_back(make_point_light(position));
    lights.back().range = range;
    lights.push_back(make_spot_light(position, aim, 20, 40));
    lights.back().range = range;
  }
  for (const bool falloff : {true, false}) {
    lights.push_back(make_point_light(position, 1, falloff));
    lights.push_back(make_spot_light(position, aim, 20, 40, falloff));
    lights.push_back(make_spot_light(position, aim, 0, min_spot_angle_deg, falloff));
    lights.push_back(make_spot_light(position, aim, 90, 90, falloff));
  }
}

/// Lights at a record, in the plane of its surface, behind it, and 1e9 scene radii away.
std::vector<Light> extreme_lights(vec3 p, vec3 n) {
  const vec3 tangent = normalize_or(glm::cross(n, {0.36f, 0.48f, 0.8f}), {1, 0, 0});
  std::vector<Light> lights;
  append_positional(p, p - n, lights);
  append_positional(p + 1e-4f * n, p, lights);
  append_positional(p + 1e-4f * tangent, p, lights);
  append_positional(p + tangent, p, lights);
  append_positional(p - 0.25f * n, p, lights);
  append_positional(1e9f * n, p, lights);
  append_positional(-1e9f * n, p, lights);
  append_positional(1e15f * tangent, p, lights);
  for (const vec3 direction : {-n, n, tangent, 1e-30f * tangent, 1e30f * tangent}) {
    lights.push_back(make_directional_light(direction));
  }
  return lights;
}

class Extremes : public testing::TestWithParam<std::tuple<InstructionSet, CacheFormat>> {
 protected:
  void SetUp() override {
    if (!is_supported(set_)) GTEST_SKIP() << "this machine or build lacks the set";
  }
  RelightStats update(RelightState& state, std::span<const Light> lights) const {
    return relight(state, lights, nullptr, {set_});
  }
  void check_layer(const RelightCache& cache, const Image& layer, const Light& light) const;
  void check_picture(int width, int height) const;

  InstructionSet set_ = std::get<0>(GetParam());
  CacheFormat format_ = std::get<1>(GetParam());
};

/// Every record within its own bound (see bound_response); light from behind gives an exact 0.
void Extremes::check_layer(const RelightCache& cache, const Image& layer,
                           const Light& light) const {
  const SampleType& type = cache.info().types[0];
  const bool is_one_sided = type.name != "kajiya-kay" && type.name != "leaf";
  const double position_error = format_ == CacheFormat::exact ? 0 : 1e-6;
  const std::vector<std::vector<float>> vectors = stored_vectors(cache);
  for (size_t pixel = 0; pixel < vectors.size(); ++pixel) {
    const float* v = vectors[pixel].data();
    if (v == nullptr) {
      ASSERT_EQ(layer.rgb(pixel), vec3(0));
      continue;
    }
    const ResponseBound bound = bound_response(type, v, light, dvec3(eye), 1, position_error);
    const auto where = [&] {
      return fmt::format("{} {} falloff {} position {} {} {} pixel {}", type.name,
                         label_of(light_type_labels, light.type), light.falloff, light.position.x,
                         light.position.y, light.position.z, pixel);
    };
    for (size_t c = 0; c < 3; ++c) {
      // Colours below the smallest normal float keep fewer digits.
      ASSERT_NEAR(layer.rgb(pixel)[c], bound.exact[c], bound.tolerance[c] + 1e-44) << where();
    }
    const dvec3 wi = light.type == LightType::directional
                         ? -glm::normalize(dvec3(light.direction))
                         : dvec3(light.position) - dvec3(v[0], v[1], v[2]);
    const double behind = -glm::dot(wi, dvec3(v[4], v[5], v[6]));
    if (is_one_sided && behind > 1e-5 * glm::length(wi) + 2 * position_error) {
      ASSERT_EQ(layer.rgb(pixel), vec3(0)) << where();
    }
  }
}

TEST_P(Extremes, LightsAtOnBehindAndFarFromRecordsMeetTheirBound) {
  for (const SampleType& type : all_sample_types()) {
    const SampleTile tile = make_extreme_tile(type);
    const RelightCache cache = make_format_cache({&tile, 1}, {type}, format_, tile_size, 5);
    const std::vector<std::vector<float>> vectors = stored_vectors(cache);
    std::vector<Light> lights;
    for (const size_t pixel : {size_t{1}, size_t{38}}) {
      ASSERT_FALSE(vectors[pixel].empty());
      const float* v = vectors[pixel].data();
      const auto more = extreme_lights({v[0], v[1], v[2]}, {v[4], v[5], v[6]});
      lights.insert(lights.end(), more.begin(), more.end());
    }
    RelightState state = make_relight_state(cache);
    EXPECT_EQ(update(state, lights).replaced_values, 0u);
    int lit = 0;
    for (size_t i = 0; i < lights.size(); ++i) {
      const Image layer = weighted_layer(state, i);
      check_layer(cache, layer, lights[i]);
      if (HasFatalFailure()) return;
      for (const float value : layer.pixels) lit += value > 0 ? 1 : 0;
    }
    EXPECT_GT(lit, 1000);
  }
}

/// A layer in double, and its largest value.
struct ReferenceLayer {
  Image image;
  double brightest = 0;
};

ReferenceLayer make_reference(const RelightCache& cache, const Light& light) {
  ReferenceLayer layer{reference_layer(cache, light, nullptr)};
  for (const float value : layer.image.pixels) {
    layer.brightest = std::max(layer.brightest, static_cast<double>(value));
  }
  return layer;
}

/// Here sums are tested, the conditioning of highlights is tested above.
std::vector<SampleTile> make_moderate_tiles(int width, int height) {
  std::vector<SampleTile> tiles = make_random_tiles(all_sample_types(), width, height, 2);
  for (SampleTile& tile : tiles) widen_highlights(all_sample_types(), tile);
  return tiles;
}

/// The least and the most that a light may be: what is too bright for a float is black and counted,
/// the rest within 2e-5 of the brightest pixel, or of what a denormal weight keeps.
TEST_P(Extremes, LightColoursFromDenormalToTheLargestMeetTheirBound) {
  const RelightCache cache =
      make_format_cache(make_moderate_tiles(16, 9), all_sample_types(), format_, 16, 9);
  Light light = make_point_light({1, 2, 3});
  const ReferenceLayer reference = make_reference(cache, light);
  RelightState state = make_relight_state(cache);
  for (const float color : {0.0f, 1e-45f, 1e-40f, 1.0f, 1e20f}) {
    for (const float gain : {0.0f, 1e-45f, 1e-20f, 1.0f, 1e18f}) {
      light.color = {color, 0, 0.5f * color};
      light.gain = gain;
      EXPECT_EQ(update(state, {&light, 1}).replaced_values, 0u);
      for (size_t i = 0; i < reference.image.pixels.size(); ++i) {
        const double weight = static_cast<double>(light.color[static_cast<int>(i % 3)]) * gain;
        ASSERT_NEAR(state.frame.pixels[i], weight * reference.image.pixels[i],
                    2e-5 * weight * reference.brightest + 2e-45 * (1 + reference.brightest))
            << color << " " << gain;
      }
    }
  }
}

TEST_P(Extremes, ALightTooBrightForAFloatLeavesUnlitPixelsToTheOthers) {
  const SampleType lambert = all_sample_types()[0];
  const SampleTile tile = make_extreme_tile(lambert);
  const RelightCache cache = make_format_cache({&tile, 1}, {lambert}, format_, tile_size, 5);
  std::vector<Light> lights = {make_directional_light({0, 0, -1}),
                               make_directional_light({0, 0, 1}, 1e20f)};
  lights[1].color = vec3(1e20f);
  RelightState state = make_relight_state(cache);
  const RelightStats stats = update(state, lights);
  const Image reference = reference_layer(cache, lights[0], nullptr);
  const Image blinding = reference_layer(cache, lights[1], nullptr);
  uint64_t kept = 0;
  for (size_t i = 0; i < reference.pixels.size(); ++i) {
    ASSERT_TRUE(is_finite(state.frame.pixels[i]));
    if (blinding.pixels[i] > 0) continue;
    ASSERT_NEAR(state.frame.pixels[i], reference.pixels[i], 2e-5f);
    kept += reference.pixels[i] > 0.01f ? 1 : 0;
  }
  EXPECT_GT(kept, 10u);
  EXPECT_LE(stats.replaced_values + kept, reference.pixels.size());
}

/// Lights of all kinds around the scene, of different colours.
std::vector<Light> make_many_lights(int count) {
  std::vector<Light> lights;
  for (int i = 0; i < count; ++i) {
    Random random(4, RandomStream::tests, i);
    const vec3 direction = random_direction(random);
    const vec3 position = random.uniform(1, 4) * direction;
    switch (i % 5) {
      case 0:
        lights.push_back(make_point_light(position));
        break;
      case 1:
        lights.push_back(make_point_light(position, 1, false));
        break;
      case 2:
        lights.push_back(make_spot_light(position, -direction, 10, 40));
        break;
      case 3:
        lights.push_back(make_spot_light(position, -direction, 5, 60, false));
        break;
      default:
        lights.push_back(make_directional_light(-direction));
    }
    lights.back().color = {random.uniform(), random.uniform(), random.uniform()};
    lights.back().gain = random.uniform(0, 3);
  }
  return lights;
}

/// Within 2e-5 of the sum of what each light does at its brightest.
TEST_P(Extremes, FramesOfNoneAndOf256LightsAreTheSumOfTheReferences) {
  const RelightCache cache =
      make_format_cache(make_moderate_tiles(16, 9), all_sample_types(), format_, 16, 9);
  RelightState state = make_relight_state(cache);
  for (const int count : {0, 256}) {
    const std::vector<Light> lights = make_many_lights(count);
    EXPECT_EQ(update(state, lights).replaced_values, 0u);
    std::vector<double> sum(state.frame.pixels.size());
    double bound = 0;
    for (const Light& light : lights) {
      const ReferenceLayer reference = make_reference(cache, light);
      for (size_t i = 0; i < sum.size(); ++i) {
        sum[i] += static_cast<double>(light.weight()[static_cast<int>(i % 3)]) *
                  reference.image.pixels[i];
      }
      bound += 2e-5 * static_cast<double>(max_component(light.weight())) * reference.brightest;
    }
    for (size_t i = 0; i < sum.size(); ++i) {
      ASSERT_NEAR(state.frame.pixels[i], sum[i], bound) << count << " lights, float " << i;
    }
  }
}

void Extremes::check_picture(int width, int height) const {
  const RelightCache cache = make_format_cache(make_moderate_tiles(width, height),
                                               all_sample_types(), format_, width, height);
  const std::vector<Light> lights = make_many_lights(5);
  RelightState state = make_relight_state(cache);
  update(state, lights);
  for (size_t i = 0; i < lights.size(); ++i) {
    const ReferenceLayer reference = make_reference(cache, lights[i]);
    const Image layer = weighted_layer(state, i);
    const vec3 weight = lights[i].weight();
    for (size_t j = 0; j < layer.pixels.size(); ++j) {
      const double factor = weight[static_cast<int>(j % 3)];
      ASSERT_NEAR(layer.pixels[j], factor * reference.image.pixels[j],
                  2e-5 * factor * reference.brightest)
          << "light " << i << " float " << j;
    }
  }
}

/// Within 2e-5 of the brightest pixel.
TEST_P(Extremes, PicturesOfOnePixelAndOfOneRowOrColumnMeetTheReference) {
  check_picture(1, 1);
  check_picture(1, 10000);
  check_picture(10000, 1);
}

INSTANTIATE_TEST_SUITE_P(
    InstructionSetsAndFormats, Extremes,
    testing::Combine(testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                     InstructionSet::avx2, InstructionSet::avx512),
                     testing::Values(CacheFormat::exact, CacheFormat::standard,
                                     CacheFormat::compact)),
    [](const auto& parameter) {
      std::string name =
          fmt::format("{}_{}", label_of(instruction_set_labels, std::get<0>(parameter.param)),
                      label_of(cache_format_labels, std::get<1>(parameter.param)));
      std::erase(name, '.');
      return name;
    });

}  // namespace
}  // namespace relume

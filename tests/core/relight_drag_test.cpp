// What makes dragging cheap: shares of the pixels, the kept sum of the other lights, missed tiles.

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/relight/light_reach.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/samples/sample_tile.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

constexpr int width = 37;
constexpr int height = 21;

/// Moves a tile's records into a ball of their own.
void gather_records(SampleTile& tile, std::span<const SampleType> types) {
  const vec3 center(tile.x0 / 16 - 1, tile.y0 / 16, 0);
  for (size_t t = 0; t < types.size(); ++t) {
    TypedRows& rows = tile.types[t];
    for (size_t row = 0; row < rows.rows(); ++row) {
      float* position = &rows.values[row * types[t].width];
      for (size_t i = 0; i < 3; ++i) position[i] = 0.3f * position[i] + center[i];
    }
  }
}

RelightCache make_random_cache() {
  const std::vector<SampleType> types = all_sample_types();
  std::vector<SampleTile> tiles = make_random_tiles(types, width, height, 3);
  for (SampleTile& tile : tiles) gather_records(tile, types);
  CacheWriter writer;
  for (const SampleTile& tile : tiles) writer.add(pack_tile(tile, types));
  CacheInfo info = make_tile_info(tiles[0], types, {0, 0, 5});
  info.width = width;
  info.height = height;
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "drag");
}

class DragTest : public testing::Test {
 protected:
  DragTest() {
    for (int i = 0; i < 3; ++i) {
      const auto x = static_cast<float>(i);
      lights_.push_back(make_point_light({x - 3, 1, 3}, 5));
      lights_.push_back(make_spot_light({2, x, 3}, {-2, 0, -3}, 20, 40));
    }
    lights_.push_back(make_directional_light({0, -1, -1}, 0.5f));
  }
  RelightStats update(const RelightParams& params) {
    return relight(state_, lights_, nullptr, params);
  }
  /// Frames may differ by what another order of the sum rounds differently.
  void expect_same_but_for_rounding() {
    const Image expected = render_frame(cache_, lights_);
    const float bound = 0x1p-23f * static_cast<float>(lights_.size());
    for (size_t i = 0; i < expected.pixels.size(); ++i) {
      ASSERT_NEAR(state_.frame.pixels[i], expected.pixels[i], bound * expected.pixels[i]) << i;
    }
  }
  /// `rounding`: relative, where the sum has another order.
  void expect_quarter_equal(const Image& exact, float rounding = 0) {
    for (int y = 0; y < height; y += 2) {
      for (int x = 0; x < width; x += 2) {
        const size_t pixel = static_cast<size_t>(y) * width + x;
        ASSERT_LE(glm::distance(state_.frame.rgb(pixel), exact.rgb(pixel)),
                  rounding * glm::length(exact.rgb(pixel)))
            << x << " " << y;
      }
    }
  }

  RelightCache cache_ = make_random_cache();
  RelightState state_ = make_relight_state(cache_);
  std::vector<Light> lights_;
};

constexpr RelightParams coarse{.pixels = PixelShare::quarter};
constexpr RelightParams dragging{.dragging = true};

TEST(PackedTiles, ListTheQuarterFirst) {
  const RelightCache cache = make_random_cache();
  for (const PackedTile& tile : cache.tiles()) {
    const int quarter = cache.block_count(tile, PixelShare::quarter);
    EXPECT_EQ(cache.block_count(tile, PixelShare::none), 0);
    EXPECT_EQ(cache.block_count(tile, PixelShare::all), tile.block_count);
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      for (int lane = 0; lane < block.lanes; ++lane) {
        const int x = tile.x0 + block.pixels[lane] % tile_size;
        const int y = tile.y0 + block.pixels[lane] / tile_size;
        EXPECT_EQ(first_share_of(x, y) == PixelShare::quarter, b < quarter) << x << " " << y;
      }
    }
  }
}

TEST_F(DragTest, AQuarterIsExactWhereItWasShaded) {
  const RelightStats stats = update(coarse);
  EXPECT_LT(stats.records_shaded, cache_.info().record_count * lights_.size() / 2);
  expect_quarter_equal(render_frame(cache_, lights_));
}

TEST_F(DragTest, CompletingAQuarterShadesTheRestAndEqualsTheWhole) {
  const uint64_t coarse_records = update(coarse).records_shaded;
  const RelightStats rest = update({});
  const uint64_t all = cache_.info().record_count * lights_.size();
  EXPECT_EQ(rest.layers_shaded, static_cast<int>(lights_.size()));
  EXPECT_NEAR(static_cast<double>(coarse_records + rest.records_shaded), static_cast<double>(all),
              0.01 * static_cast<double>(all));
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
  EXPECT_EQ(update({}).layers_shaded, 0);
}

TEST_F(DragTest, LayersOfDifferentSharesMix) {
  update({});
  lights_[0].position.x += 0.5f;
  EXPECT_EQ(update(coarse).layers_shaded, 1);
  lights_[6].direction.x += 0.5f;
  EXPECT_EQ(update(coarse).layers_shaded, 1);  // the first one stays coarse
  expect_quarter_equal(render_frame(cache_, lights_), 1e-6f);
  EXPECT_EQ(update({}).layers_shaded, 2);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(DragTest, ACoarseLightMovedAgainStartsOver) {
  update(coarse);
  for (Light& light : lights_) light.position.x += 0.25f;
  lights_[6].direction.x += 0.5f;
  update({});
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

/// One record in every pixel, all alike but for the weight: fifths of a pixel.
SampleTile make_even_tile(const std::vector<SampleType>& types) {
  Random random(1, RandomStream::tests, 0);
  std::vector<float> vector;
  append_random_vector(types[0], random, vector);
  SampleTile tile = make_random_tile(types, 16, 16, 0, 1);
  TypedRows& rows = tile.types[0];
  rows.first.assign(1, 0);
  for (int pixel = 0; pixel < 256; ++pixel) {
    rows.values.insert(rows.values.end(), vector.begin(), vector.end());
    rows.weights.push_back(static_cast<float>(1 + pixel % 5) / 5);
    rows.first.push_back(static_cast<uint32_t>(rows.rows()));
  }
  return tile;
}

TEST_F(DragTest, MissingPixelsOfAnEvenSurfaceAreExact) {
  const std::vector<SampleType> types = all_sample_types();
  const RelightCache cache = make_tile_cache(make_even_tile(types), types, {0, 0, 5});
  RelightState state = make_relight_state(cache);
  relight(state, lights_, nullptr, coarse);
  const Image exact = render_frame(cache, lights_);
  float brightest = 0;
  for (const float value : exact.pixels) brightest = std::max(brightest, value);
  ASSERT_GT(brightest, 0);
  EXPECT_LE(max_difference(state.frame, exact), 1e-5f * brightest);  // n / 5 is n * 51 / 255
}

TEST_F(DragTest, TheKeptSumGivesTheSameFrames) {
  update(dragging);
  for (int move = 0; move < 3; ++move) {
    lights_[1].position.y += 0.25f;
    EXPECT_EQ(update(dragging).layers_shaded, 1);
    EXPECT_EQ(state_.others_of, 1u);
    expect_same_but_for_rounding();
  }
  lights_[1].gain = 3;
  EXPECT_EQ(update(dragging).layers_shaded, 0);
  expect_same_but_for_rounding();
  lights_[1].position.y += 0.25f;
  RelightParams both = dragging;
  both.pixels = PixelShare::quarter;
  update(both);
  EXPECT_EQ(state_.others_of, 1u);
  update({});
  EXPECT_FALSE(state_.others_of);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(DragTest, TheKeptSumEndsWhenAnythingElseChanges) {
  const std::vector<void (*)(std::vector<Light>&)> changes = {
      [](std::vector<Light>& l) { l[2].gain = 4; },
      [](std::vector<Light>& l) {
        l[2].color = {1, 0, 2};
      },
      [](std::vector<Light>& l) { l[2].mute = true; },
      [](std::vector<Light>& l) { l[2].mute = false; },
      [](std::vector<Light>& l) { l[2].position.x += 1; },
      [](std::vector<Light>& l) { l[3].type = LightType::point; },
      [](std::vector<Light>& l) { l.push_back(l[0]); },
      [](std::vector<Light>& l) { l.erase(l.begin() + 2); },
      [](std::vector<Light>& l) { std::swap(l[2], l[3]); },
      [](std::vector<Light>& l) { l[0].mute = true; },
      [](std::vector<Light>& l) { l.resize(2); },
      [](std::vector<Light>& l) { l.clear(); },
      [](std::vector<Light>& l) {
        l.push_back(make_point_light({0, 0, 3}, 1));
      },
  };
  update(dragging);
  for (const auto& change : changes) {
    if (!lights_.empty()) lights_[0].position.x += 0.125f;
    update(dragging);
    change(lights_);
    update(dragging);
    expect_same_but_for_rounding();
    if (!lights_.empty()) lights_[0].position.x += 0.125f;
    update(dragging);
    expect_same_but_for_rounding();
  }
}

TEST_F(DragTest, InvalidateEndsTheKeptSum) {
  update(dragging);
  lights_[1].position.y += 0.25f;
  update(dragging);
  invalidate(state_);
  EXPECT_EQ(update(dragging).layers_shaded, static_cast<int>(lights_.size()));
  expect_same_but_for_rounding();
}

TEST_F(DragTest, ACancelledCallLeavesNothingWrong) {
  const std::atomic<bool> yes{true};
  update(coarse);
  lights_[0].position.x += 1;
  RelightParams stopped;
  stopped.cancelled = &yes;
  EXPECT_THROW(update(stopped), Error);
  EXPECT_EQ(update({}).layers_shaded, static_cast<int>(lights_.size()));
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

/// A tile as small as a point is missed right behind the end of the light, not far behind.
TEST(LightReach, EndsWhereTheRangeAndTheConeEnd) {
  const auto reaches = [](const Light& light, vec3 p) {
    Bounds point;
    point.extend(p);
    return can_reach(make_kernel_light(light, 1), point);
  };
  Light lamp = make_point_light({1, 0, 0});
  lamp.range = 2;
  EXPECT_TRUE(reaches(lamp, {2.99f, 0, 0}));
  EXPECT_FALSE(reaches(lamp, {3.02f, 0, 0}));
  const Light spot = make_spot_light({0, 0, 0}, {0, 0, -1}, 10, 45);
  EXPECT_TRUE(reaches(spot, {0.99f, 0, -1}));
  EXPECT_FALSE(reaches(spot, {1.03f, 0, -1}));
  EXPECT_FALSE(reaches(spot, {0, 0, 1}));
}

/// Random narrow spots and short lights in and around the records; none may lose a lit tile.
TEST_F(DragTest, ATileIsMissedOnlyWhereItGetsNothing) {
  const std::vector<Bounds> bounds = tile_bounds(cache_);
  Random random(7, RandomStream::tests, 0);
  int missed = 0;
  for (int i = 0; i < 60; ++i) {
    const vec3 position = 4.0f * random_direction(random);
    const vec3 target = random_direction(random);
    const float outer = std::exp2(random.uniform(-1, 6.4f));
    Light light = make_spot_light(position, target - position, 0.5f * outer, outer);
    if (i % 3 == 1) light.type = LightType::point;
    if (i % 3 != 0) light.range = random.uniform(0.5f, 5);
    const Image layer = reference_layer(cache_, light, nullptr);
    const KernelLight kernel = make_kernel_light(light, cache_.info().bounds.radius());
    for (size_t t = 0; t < bounds.size(); ++t) {
      if (can_reach(kernel, bounds[t])) continue;
      ++missed;
      const PackedTile& tile = cache_.tiles()[t];
      for (int y = tile.y0; y < tile.y0 + tile.height; ++y) {
        for (int x = tile.x0; x < tile.x0 + tile.width; ++x) {
          ASSERT_EQ(layer.rgb(static_cast<size_t>(y) * width + x), vec3(0)) << "light " << i;
        }
      }
    }
  }
  EXPECT_GT(missed, 20);
}

TEST_F(DragTest, MissedTilesAreCountedAndBlack) {
  lights_ = {make_spot_light({9, 9, 9}, {1, 1, 1}, 5, 10)};  // away from everything
  EXPECT_EQ(update({}).tiles_missed, cache_.tiles().size());
  EXPECT_EQ(max_difference(state_.frame, Image(width, height)), 0);
  lights_ = {make_point_light({9, 9, 9})};
  lights_[0].range = 2;
  EXPECT_EQ(update({}).tiles_missed, cache_.tiles().size());
  EXPECT_EQ(max_difference(state_.frame, Image(width, height)), 0);
  lights_[0].range = 30;
  EXPECT_LT(update({}).tiles_missed, cache_.tiles().size());
  EXPECT_GT(max_difference(state_.frame, Image(width, height)), 0);
}

}  // namespace
}  // namespace relume

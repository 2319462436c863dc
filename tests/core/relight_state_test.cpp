#include <gtest/gtest.h>

#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

class RelightTest : public testing::Test {
 protected:
  RelightTest() {
    lights_ = {make_point_light({0, 1, 3}, 5), make_spot_light({2, 0, 3}, {-2, 0, -3}, 20, 40),
               make_directional_light({0, -1, -1}, 0.5f)};
    lights_[1].color = {1, 0.5f, 0.25f};
  }
  RelightStats update(VisibilitySource* shadows = nullptr) {
    return relight(state_, lights_, shadows);
  }

  std::vector<SampleType> types_ = all_sample_types();
  SampleTile tile_ = make_random_tile(types_, 16, 16, 3, 2);
  RelightCache cache_ = make_tile_cache(tile_, types_, {0, 0, 5});
  RelightState state_ = make_relight_state(cache_);
  std::vector<Light> lights_;
};

TEST_F(RelightTest, FrameIsTheSumOfTheWeightedLayers) {
  update();
  for (size_t pixel = 0; pixel < 256; ++pixel) {
    dvec3 sum(0);
    for (size_t i = 0; i < lights_.size(); ++i) {
      sum += dvec3(lights_[i].weight()) * dvec3(layer_image(state_, i).rgb(pixel));
    }
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(state_.frame.rgb(pixel)[c], sum[c], 1e-6 * sum[c]);
    }
  }
}

TEST_F(RelightTest, WeightedLayersSumToTheFrame) {
  update();
  Image sum(16, 16);
  for (size_t i = 0; i < lights_.size(); ++i) {
    const Image layer = weighted_layer(state_, i);
    for (size_t j = 0; j < sum.pixels.size(); ++j) sum.pixels[j] += layer.pixels[j];
  }
  for (size_t j = 0; j < sum.pixels.size(); ++j) {
    EXPECT_NEAR(sum.pixels[j], state_.frame.pixels[j], 1e-6f * sum.pixels[j]);
  }
}

TEST_F(RelightTest, ScalingEveryGainScalesTheFrame) {
  update();
  const Image before = state_.frame;
  for (Light& light : lights_) light.gain *= 4;  // a power of two: exact
  EXPECT_EQ(update().layers_shaded, 0);
  for (size_t j = 0; j < before.pixels.size(); ++j) {
    EXPECT_EQ(state_.frame.pixels[j], 4 * before.pixels[j]);
  }
}

TEST_F(RelightTest, OnlyTheMovedLightIsShadedAnew) {
  const RelightStats first = update();
  EXPECT_EQ(first.layers_shaded, 3);
  EXPECT_EQ(first.records_shaded, 3 * tile_.row_count());
  EXPECT_EQ(update().layers_shaded, 0);
  const Image kept = layer_image(state_, 0);
  lights_[1].position.x += 0.5f;
  EXPECT_EQ(update().layers_shaded, 1);
  EXPECT_EQ(layer_image(state_, 0).pixels, kept.pixels);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(RelightTest, LightsOfAllKindsInOnePassEqualEachAlone) {
  // Seven of one kind and some of each other: passes of four, two and one light.
  lights_.clear();
  for (int i = 0; i < 7; ++i) {
    const auto x = static_cast<float>(i);
    lights_.push_back(make_point_light({x - 3, 1, 3}, 5));
    if (i % 2 == 0) lights_.push_back(make_spot_light({2, x, 3}, {-2, 0, -3}, 20, 40));
    if (i % 3 == 0) lights_.push_back(make_directional_light({0, -1, -x}, 0.5f));
    if (i % 3 == 1) lights_.push_back(make_point_light({x, 1, 3}, 5, false));
  }
  EXPECT_EQ(update().layers_shaded, static_cast<int>(lights_.size()));
  for (size_t i = 0; i < lights_.size(); ++i) {
    RelightState alone = make_relight_state(cache_);
    relight(alone, {&lights_[i], 1}, nullptr);
    EXPECT_EQ(layer_image(state_, i).pixels, layer_image(alone, 0).pixels) << "light " << i;
  }
}

TEST_F(RelightTest, TilesAtTheEdgesAreWrittenToTheirLastPixel) {
  std::vector<SampleTile> tiles = make_random_tiles(types_, 37, 21, 3);
  CacheWriter writer;
  for (const SampleTile& tile : tiles) writer.add(pack_tile(tile, types_));
  CacheInfo info = make_tile_info(tiles[0], types_, {0, 0, 5});
  info.width = 37;
  info.height = 21;
  writer.finish(info);
  const RelightCache cache = RelightCache::from_bytes(writer.take_bytes(), shader_table(), "edges");
  RelightState state = make_relight_state(cache);
  for (int move = 0; move < 2; ++move) {
    lights_[0].position.x += 0.5f;
    relight(state, lights_, nullptr);
    const Image exact = reference_layer(cache, lights_[0], nullptr);  // exponents up to 1e5
    float brightest = 0;
    for (const float value : exact.pixels) brightest = std::max(brightest, value);
    EXPECT_LE(max_difference(layer_image(state, 0), exact), 1e-2f * brightest);
    for (int y = 0; y < 21; ++y) {
      for (int x = 0; x < 37; ++x) {
        vec3 sum(0);
        for (size_t i = 0; i < lights_.size(); ++i) {
          sum += lights_[i].weight() * layer_image(state, i).rgb(static_cast<size_t>(y) * 37 + x);
        }
        ASSERT_LE(glm::distance(state.frame.rgb(static_cast<size_t>(y) * 37 + x), sum),
                  1e-5f * (1 + glm::length(sum)))
            << x << " " << y;
      }
    }
  }
}

TEST_F(RelightTest, ColourGainNameAndMuteShadeNothing) {
  update();
  lights_[0].gain = 9;
  lights_[0].name = "other";
  lights_[1].color = {0, 0, 3};
  lights_[2].mute = true;
  EXPECT_EQ(update().layers_shaded, 0);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(RelightTest, EveryGeometryFieldShadesItsLayer) {
  const std::vector<std::pair<size_t, void (*)(Light&)>> changes = {
      {0, [](Light& l) { l.position.y = 2; }},
      {0, [](Light& l) { l.range = 5; }},
      {0, [](Light& l) { l.falloff = false; }},
      {0, [](Light& l) { l.casts_shadow = false; }},
      {0, [](Light& l) { l.type = LightType::spot; }},
      {1, [](Light& l) { l.direction.x = -1; }},
      {1, [](Light& l) { l.inner_angle_deg = 5; }},
      {1, [](Light& l) { l.outer_angle_deg = 50; }},
      {2, [](Light& l) { l.direction.z = 1; }},
  };
  update();
  for (size_t i = 0; i < changes.size(); ++i) {
    changes[i].second(lights_[changes[i].first]);
    EXPECT_EQ(update().layers_shaded, 1) << "change " << i;
    EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0) << "change " << i;
  }
  // What a light's kind does not read does not matter.
  lights_[2].position = {7, 7, 7};
  lights_[2].falloff = false;
  lights_[2].range = 3;
  lights_[0].falloff = false;
  update();
  lights_[0].range = 3;
  EXPECT_EQ(update().layers_shaded, 0);
}

TEST_F(RelightTest, MutedLightMovesForNothingAndComesBackRight) {
  update();
  lights_[0].mute = true;
  lights_[0].position = {1, 1, 2};
  EXPECT_EQ(update().layers_shaded, 0);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
  EXPECT_EQ(max_difference(weighted_layer(state_, 0), Image(16, 16)), 0);
  lights_[0].mute = false;
  EXPECT_EQ(update().layers_shaded, 1);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(RelightTest, LightsMayBeAddedAndRemoved) {
  update();
  lights_.push_back(make_point_light({-1, 0, 2}));
  EXPECT_EQ(update().layers_shaded, 1);
  lights_.erase(lights_.begin());
  update();
  EXPECT_EQ(state_.layers.size(), 3u);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(RelightTest, NoLightIsBlack) {
  update();
  lights_.clear();
  EXPECT_EQ(update().layers_shaded, 0);
  EXPECT_EQ(max_difference(state_.frame, Image(16, 16)), 0);
}

TEST_F(RelightTest, ManyLightsSum) {
  lights_.assign(256, make_point_light({0, 1, 3}, 0.25f));
  EXPECT_EQ(update().layers_shaded, 256);
  const std::vector<Light> one = {make_point_light({0, 1, 3}, 64)};
  const Image expected = render_frame(cache_, one);
  for (size_t j = 0; j < expected.pixels.size(); ++j) {
    EXPECT_NEAR(state_.frame.pixels[j], expected.pixels[j], 1e-4f * expected.pixels[j]);
  }
}

TEST_F(RelightTest, InvalidateShadesEverything) {
  update();
  invalidate(state_);
  EXPECT_EQ(update().layers_shaded, 3);
}

TEST_F(RelightTest, InvalidLightChangesNothing) {
  update();
  const Image frame = state_.frame;
  const Image layer = layer_image(state_, 0);
  lights_[0].position = {5, 5, 5};
  lights_[2].direction = vec3(0);
  lights_[2].name = "key";
  EXPECT_ERROR(update(), ErrorKind::input, "lights/2 (key)/direction");
  EXPECT_EQ(max_difference(state_.frame, frame), 0);
  EXPECT_EQ(max_difference(layer_image(state_, 0), layer), 0);
  lights_[2].direction = {0, -1, -1};
  EXPECT_EQ(update().layers_shaded, 1);
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

/// Fails from its n-th prepare() on.
class FailingVisibility final : public VisibilitySource {
 public:
  explicit FailingVisibility(int good) : left_(good) {}
  void prepare(const Light&) override {
    if (left_-- == 0) throw Error(ErrorKind::cancelled, "stopped");
  }
  void visibility(const Receivers& receivers, float* visibility) const override {
    std::fill_n(visibility, receivers.count, 1.0f);
  }

 private:
  int left_;
};

TEST_F(RelightTest, FailureOnTheWayLeavesNoStaleLayer) {
  update();
  const std::vector<Light> before = lights_;
  for (Light& light : lights_) {
    light.position.y -= 1;
    light.direction.x += 0.5f;
  }
  FailingVisibility failing(1);
  EXPECT_THROW(update(&failing), Error);
  lights_ = before;
  update();
  EXPECT_EQ(max_difference(state_.frame, render_frame(cache_, lights_)), 0);
}

TEST_F(RelightTest, UnshadowedLightIsNotPreparedForShadows) {
  for (Light& light : lights_) light.casts_shadow = false;
  FailingVisibility failing(0);
  EXPECT_EQ(update(&failing).layers_shaded, 3);
}

TEST_F(RelightTest, NonFiniteValuesAreReplacedAndCounted) {
  // The largest weights there are: the frame overflows where it is lit, and stays finite.
  for (Light& light : lights_) {
    light.color = vec3(1e20f);
    light.gain = 1e20f;
  }
  const RelightStats stats = update();
  EXPECT_GT(stats.replaced_values, 0u);
  for (const float value : state_.frame.pixels) EXPECT_TRUE(is_finite(value));
}

TEST_F(RelightTest, BlackLightsAndBlackRecordsAreBlack) {
  for (Light& light : lights_) light.color = vec3(0);
  update();
  EXPECT_EQ(max_difference(state_.frame, Image(16, 16)), 0);
}

struct BadLight {
  const char* field;
  void (*change)(Light&);
};

class LightValidation : public testing::TestWithParam<BadLight> {};

TEST_P(LightValidation, NamesTheField) {
  Light light = make_spot_light({0, 1, 2}, {0, -1, 0}, 20, 30);
  validate_light(light, "ok");
  GetParam().change(light);
  EXPECT_ERROR(validate_light(light, "here"), ErrorKind::input,
               std::string("here/") + GetParam().field);
}

constexpr float nan_value = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

INSTANTIATE_TEST_SUITE_P(
    Fields, LightValidation,
    testing::Values(BadLight{"position", [](Light& l) { l.position.x = nan_value; }},
                    BadLight{"position", [](Light& l) { l.position.z = -infinity; }},
                    BadLight{"position", [](Light& l) { l.position.y = 1e19f; }},
                    BadLight{"position", [](Light& l) { l.position.y = -3e38f; }},
                    BadLight{"direction", [](Light& l) { l.direction = vec3(0); }},
                    BadLight{"direction", [](Light& l) { l.direction.x = nan_value; }},
                    BadLight{"inner_angle_deg", [](Light& l) { l.inner_angle_deg = -1; }},
                    BadLight{"inner_angle_deg", [](Light& l) { l.inner_angle_deg = 31; }},
                    BadLight{"inner_angle_deg", [](Light& l) { l.inner_angle_deg = nan_value; }},
                    BadLight{"outer_angle_deg", [](Light& l) { l.outer_angle_deg = 0; }},
                    BadLight{"outer_angle_deg", [](Light& l) { l.outer_angle_deg = 90.5f; }},
                    BadLight{"outer_angle_deg", [](Light& l) { l.outer_angle_deg = nan_value; }},
                    BadLight{"color", [](Light& l) { l.color.y = -1; }},
                    BadLight{"color", [](Light& l) { l.color.z = nan_value; }},
                    BadLight{"color", [](Light& l) { l.color.x = 1e21f; }},
                    BadLight{"gain", [](Light& l) { l.gain = -0.1f; }},
                    BadLight{"gain", [](Light& l) { l.gain = infinity; }},
                    BadLight{"gain", [](Light& l) { l.gain = nan_value; }}));

TEST(InterpolatedLight, LiesInTheBoxAndDependsOnSeedAndIndexAlone) {
  Light low = make_spot_light({0, 0, 0}, {0, -1, 0}, 10, 30);
  Light high = make_spot_light({1, 2, 3}, {1, -2, 0.5f}, 20, 60);
  high.color = {2, 2, 4};
  high.gain = 5;
  vec3 mean(0);
  for (uint64_t i = 0; i < 1000; ++i) {
    const Light light = interpolate_light(low, high, 3, i);
    validate_light(light, "interpolated");
    EXPECT_TRUE(same_layer(light, interpolate_light(low, high, 3, i)));
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_GE(light.position[c], low.position[c]);
      EXPECT_LE(light.position[c], high.position[c]);
    }
    EXPECT_LE(light.gain, 5);
    mean += light.position / 1000.0f;
  }
  // Six standard errors of a uniform distribution.
  EXPECT_NEAR(mean.x, 0.5, 6 * 0.289 / std::sqrt(1000));
  EXPECT_NEAR(mean.z, 1.5, 6 * 0.289 * 3 / std::sqrt(1000));
  EXPECT_FALSE(same_layer(interpolate_light(low, high, 3, 0), interpolate_light(low, high, 4, 0)));
}

TEST(InterpolatedLight, OppositeDirectionsStayValid) {
  const Light low = make_directional_light({0, -1, 0});
  const Light high = make_directional_light({0, 1, 0});
  for (uint64_t i = 0; i < 100; ++i) {
    EXPECT_NO_THROW(validate_light(interpolate_light(low, high, 1, i), "between")) << i;
  }
}

}  // namespace
}  // namespace relume

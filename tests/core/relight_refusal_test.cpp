#include <gtest/gtest.h>

#include <limits>

#include "core/relight/relight.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

/// A numeric parameter of a light.
struct LightNumber {
  const char* field;
  float* (*get)(Light&);
};

constexpr LightNumber light_numbers[] = {
    {"position", [](Light& l) { return &l.position.x; }},
    {"position", [](Light& l) { return &l.position.y; }},
    {"position", [](Light& l) { return &l.position.z; }},
    {"direction", [](Light& l) { return &l.direction.x; }},
    {"direction", [](Light& l) { return &l.direction.y; }},
    {"direction", [](Light& l) { return &l.direction.z; }},
    {"inner_angle_deg", [](Light& l) { return &l.inner_angle_deg; }},
    {"outer_angle_deg", [](Light& l) { return &l.outer_angle_deg; }},
    {"color", [](Light& l) { return &l.color.x; }},
    {"color", [](Light& l) { return &l.color.y; }},
    {"color", [](Light& l) { return &l.color.z; }},
    {"gain", [](Light& l) { return &l.gain; }},
};

/// Every number of a light, in a light of every type.
class RefusedLight : public testing::TestWithParam<std::tuple<LightType, size_t>> {};

TEST_P(RefusedLight, IsNamedWithItsFieldAndLeavesTheFrame) {
  const std::vector<SampleType> types = all_sample_types();
  const RelightCache cache =
      make_tile_cache(make_random_tile(types, 16, 16, 2, 1), types, {0, 0, 5});
  std::vector<Light> lights = {make_point_light({0, 1, 3}), make_point_light({1, 0, 3})};
  lights[1].type = std::get<0>(GetParam());
  lights[1].name = "key";
  RelightState state = make_relight_state(cache);
  relight(state, lights, nullptr);
  const Image frame = state.frame;
  const LightNumber& number = light_numbers[std::get<1>(GetParam())];
  for (const float value :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
        -std::numeric_limits<float>::infinity()}) {
    std::vector<Light> bad = lights;
    bad[0].position.x = 7;  // good, but must not be taken either
    *number.get(bad[1]) = value;
    EXPECT_ERROR(relight(state, bad, nullptr), ErrorKind::input,
                 std::string("lights/1 (key)/") + number.field);
    EXPECT_EQ(state.frame.pixels, frame.pixels);
    for (size_t i = 0; i < lights.size(); ++i) {
      EXPECT_TRUE(same_layer(state.lights[i], lights[i])) << i;
    }
  }
  EXPECT_EQ(relight(state, lights, nullptr).layers_shaded, 0);
  EXPECT_EQ(state.frame.pixels, frame.pixels);
}

INSTANTIATE_TEST_SUITE_P(NumbersOfLights, RefusedLight,
                         testing::Combine(testing::Values(LightType::point, LightType::spot,
                                                          LightType::directional),
                                          testing::Range(size_t{0}, std::size(light_numbers))));

TEST(RefusedFirstLight, LeavesTheStateReadyForAGoodOne) {
  const std::vector<SampleType> types = all_sample_types();
  const RelightCache cache =
      make_tile_cache(make_random_tile(types, 16, 16, 2, 1), types, {0, 0, 5});
  Light light = make_point_light({0, 1, 3});
  RelightState state = make_relight_state(cache);
  light.gain = std::numeric_limits<float>::quiet_NaN();
  EXPECT_ERROR(relight(state, {&light, 1}, nullptr), ErrorKind::input, "lights/0 (light)/gain");
  EXPECT_EQ(max_difference(state.frame, Image(16, 16)), 0);
  light.gain = 1;
  relight(state, {&light, 1}, nullptr);
  EXPECT_EQ(state.frame.pixels, render_frame(cache, {&light, 1}).pixels);
}

}  // namespace
}  // namespace relume

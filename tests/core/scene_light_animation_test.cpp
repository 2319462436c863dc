// Keyframes and turntables of lights.

#include <gtest/gtest.h>

#include "core/scene/io/load_light_animations.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/light_animation.h"
#include "tests/support/expect_error.h"

namespace relume::test {
namespace {

/// One light with these keys, at a frame.
Light light_of(const std::string& keys, float frame) {
  const std::string text = "{\"lights\": [{\"name\": \"a\", " + keys + "}]}";
  return lights_at(parse_lights(text, "x.json"), parse_light_animations(text, "x.json"), frame)[0];
}

void expect_broken(const std::string& keys, const std::string& part) {
  EXPECT_ERROR(parse_lights("{\"lights\": [{" + keys + "}]}", "x.json"), ErrorKind::input, part);
}

TEST(LightAnimation, IsLinearBetweenKeyframesAndConstantBeyond) {
  const std::string keys =
      R"("gain": 9, "keyframes": {"gain": [[10, 1], [20, 3], [22, 0]],
                                  "position": [[0, [0, 0, 0]], [8, [8, 4, -8]]]})";
  EXPECT_EQ(light_of(keys, -5).gain, 1);
  EXPECT_EQ(light_of(keys, 10).gain, 1);
  EXPECT_EQ(light_of(keys, 15).gain, 2);
  EXPECT_EQ(light_of(keys, 20).gain, 3);
  EXPECT_EQ(light_of(keys, 21).gain, 1.5f);
  EXPECT_EQ(light_of(keys, 100).gain, 0);
  EXPECT_EQ(light_of(keys, 2).position, vec3(2, 1, -2));
  EXPECT_EQ(light_of(keys, 99).position, vec3(8, 4, -8));
}

TEST(LightAnimation, WithoutItALightStaysWhatItIs) {
  EXPECT_EQ(light_of(R"("gain": 9, "position": [1, 2, 3])", 7).position, vec3(1, 2, 3));
  EXPECT_EQ(light_of(R"("gain": 9, "keyframes": {"color": [[1, [1, 0, 0]]]})", 7).gain, 9);
}

TEST(LightAnimation, ATurntableKeepsDistanceAndClosesItsLoop) {
  const std::string keys =
      R"("position": [3, 2, 1], "direction": [-1, 0, 0],
         "turntable": {"center": [1, 5, 1], "axis": [0, 2, 0], "frames": [1, 9]})";
  EXPECT_EQ(light_of(keys, 1).position, vec3(3, 2, 1));
  EXPECT_EQ(light_of(keys, 9).position, vec3(3, 2, 1));
  const Light quarter = light_of(keys, 3);
  EXPECT_NEAR(glm::distance(quarter.position, vec3(1, 2, -1)), 0, 1e-6);
  EXPECT_NEAR(glm::distance(quarter.direction, vec3(0, 0, 1)), 0, 1e-6);
  for (int frame = -20; frame < 20; ++frame) {
    const Light light = light_of(keys, static_cast<float>(frame));
    EXPECT_NEAR(glm::distance(light.position, vec3(1, 2, 1)), 2, 1e-5) << frame;
    EXPECT_NEAR(
        glm::distance(light.position, light_of(keys, static_cast<float>(frame + 8)).position), 0,
        1e-5)
        << frame;
  }
}

TEST(LightAnimation, AnAimedLightStaysAimed) {
  const std::string moving =
      R"("type": "spot", "position": [3, 2, 1], "target": [0, 1, 0],
         "keyframes": {"position": [[0, [3, 2, 1]], [10, [-7, 4, 2]]]})";
  const std::string turning =
      R"("type": "spot", "position": [3, 2, 1], "target": [0, 1, 0],
         "turntable": {"center": [0.5, 0, 0], "frames": [0, 7], "degrees": 100})";
  for (const std::string& keys : {moving, turning}) {
    for (const float frame : {0.0f, 1.0f, 5.5f, 30.0f}) {
      const Light light = light_of(keys, frame);
      EXPECT_NEAR(glm::distance(light.position + light.direction, vec3(0, 1, 0)), 0, 1e-5);
    }
  }
  const std::string led = R"("type": "spot", "position": [3, 2, 1],
                             "keyframes": {"target": [[0, [0, 0, 0]], [2, [2, 0, 0]]]})";
  EXPECT_EQ(light_of(led, 1).direction, vec3(-2, -2, -1));
}

TEST(LightAnimation, WhatMakesNoSenseIsNamed) {
  expect_broken(R"("keyframes": {"gain": []})", "/lights/0/keyframes/gain: is empty");
  expect_broken(R"("keyframes": {"gain": [[1, 2], [1, 3]]})", "does not come after");
  expect_broken(R"("keyframes": {"gain": [[1]]})", "is no keyframe");
  expect_broken(R"("keyframes": {"gain": [[1, -2]]})", "/lights/0/keyframes/gain/0/1");
  expect_broken(R"("keyframes": {"gian": [[1, 2]]})", "gian");
  expect_broken(R"("keyframes": {"position": [[1, {"relative": [0, 0, 0]}]]})", "position/0/1");
  expect_broken(R"("target": [1, 1, 1], "keyframes": {"direction": [[1, [0, 1, 0]]]})",
                "beside a target");
  expect_broken(R"("turntable": {})", "give [first, last]");
  expect_broken(R"("turntable": {"frames": [4, 4]})", "do not ascend");
  expect_broken(R"("turntable": {"frames": [1, 4], "axis": [0, 0, 0]})", "is zero");
}

}  // namespace
}  // namespace relume::test

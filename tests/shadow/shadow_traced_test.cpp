#include <gtest/gtest.h>

#include "core/base/random.h"
#include "shadow/shadow.h"
#include "shadow/traced.h"
#include "tests/support/receiver_set.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

std::vector<float> visibility_of(const Scene& scene, const Light& light,
                                 const Receivers& receivers) {
  const Tracer tracer(scene);
  TracedVisibility traced(tracer);
  traced.prepare(light);
  std::vector<float> visibility(static_cast<size_t>(receivers.count), -1.0f);
  traced.visibility(receivers, visibility.data());
  return visibility;
}

/// A small far-off quad, so that there is something to trace.
Scene make_empty_sky() {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_quad({0, 0, -500}, {1, 0, 0}, {0, 1, 0}, material));
  return scene;
}

ReceiverSet random_receivers(int count, uint64_t seed) {
  ReceiverSet receivers;
  for (int i = 0; i < count; ++i) {
    Random random(seed, RandomStream::tests, static_cast<uint64_t>(i));
    const vec3 p = random_direction(random);
    const vec3 n = random_direction(random);
    receivers.add(p, n, 1e-5f);
  }
  return receivers;
}

const std::vector<Light>& some_lights() {
  static const std::vector<Light> lights = {
      make_point_light({2, 3, 1}), make_point_light({0.1f, 0, 0}),
      make_spot_light({0, 4, 0}, {0, -1, 0}, 10, 20), make_directional_light({1, -2, 0.5f})};
  return lights;
}

TEST(TracedVisibility, IsOneWhereNothingStands) {
  const ReceiverSet receivers = random_receivers(200, 1);
  for (const Light& light : some_lights()) {
    for (const float value : visibility_of(make_empty_sky(), light, receivers.view(true))) {
      EXPECT_EQ(value, 1.0f);
    }
  }
}

TEST(TracedVisibility, EveryOccluderOnlyDarkens) {
  const ReceiverSet receivers = random_receivers(300, 2);
  for (const bool surface : {true, false}) {
    for (const Light& light : some_lights()) {
      Scene scene = make_empty_sky();
      std::vector<float> before = visibility_of(scene, light, receivers.view(surface));
      Random random(3, RandomStream::tests, 0);
      for (int step = 0; step < 6; ++step) {
        const vec3 center = 1.5f * random_direction(random);
        const float radius = random.uniform(0.1f, 0.4f);
        add_shape(scene, make_sphere(center, radius, 8, 0));
        const std::vector<float> now = visibility_of(scene, light, receivers.view(surface));
        for (size_t i = 0; i < now.size(); ++i) {
          EXPECT_GE(now[i], 0.0f);
          EXPECT_LE(now[i], before[i]) << "receiver " << i << " step " << step;
        }
        before = now;
      }
    }
  }
}

TEST(TracedVisibility, BlockedWhereAQuadStandsBetween) {
  Scene scene = make_empty_sky();
  add_shape(scene, make_quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 0));
  ReceiverSet receivers;
  receivers.add({0, 0, 0}, {0, 0, 1}, 1e-5f);     // under the quad
  receivers.add({0, 0, 2}, {0, 0, 1}, 1e-5f);     // above it
  receivers.add({0, 0, 0}, {0, 0, -1}, 1e-5f);    // faces away: visibility does not matter, no ray
  receivers.add({0, 0, 0}, {0, 0, 1}, 1e-5f, 0);  // padding
  receivers.add({2.1f, 0, 0}, {0, 0, 1}, 1e-5f);  // just beside the shadow of a light at height 2
  receivers.add({1.9f, 0, 0}, {0, 0, 1}, 1e-5f);  // just within
  const auto seen = visibility_of(scene, make_point_light({0, 0, 2}), receivers.view(true));
  EXPECT_EQ(seen[0], 0);
  EXPECT_EQ(seen[1], 1) << "the light lies on the receiver";
  EXPECT_EQ(seen[2], 1);
  EXPECT_TRUE(is_finite(seen[3]));
  EXPECT_EQ(seen[4], 1);
  EXPECT_EQ(seen[5], 0);
  // Light that goes through a leaf is blocked like any other.
  EXPECT_EQ(visibility_of(scene, make_point_light({0, 0, 2}), receivers.view(true, true))[2], 0);
}

TEST(TracedVisibility, OccludersBehindTheLightDoNotCount) {
  Scene scene = make_empty_sky();
  add_shape(scene, make_quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}, 0));
  ReceiverSet receivers;
  receivers.add({0, 0, 0}, {0, 0, 1}, 1e-5f);
  EXPECT_EQ(visibility_of(scene, make_point_light({0, 0, 0.9f}), receivers.view(true))[0], 1);
  EXPECT_EQ(visibility_of(scene, make_point_light({0, 0, 1.1f}), receivers.view(true))[0], 0);
  EXPECT_EQ(visibility_of(scene, make_directional_light({0, 0, -1}), receivers.view(true))[0], 0);
}

TEST(TracedVisibility, LightsVeryNearAndVeryFarStayInRange) {
  Scene scene = make_empty_sky();
  add_shape(scene, make_sphere(vec3(0), 0.5f, 12, 0));
  const ReceiverSet receivers = random_receivers(100, 5);
  for (const float distance : {0.0f, 1e-30f, 1e-6f, 1e9f, 1e15f}) {
    const Light light = make_point_light({distance, 0, 0});
    for (const float value : visibility_of(scene, light, receivers.view(true))) {
      EXPECT_TRUE(value == 0 || value == 1) << distance;
    }
  }
}

TEST(TracedVisibility, InstancedAndFlattenedAgree) {
  Scene scene = make_empty_sky();
  add_shape(scene, make_sphere(vec3(0), 0.3f, 10, 0));
  for (int i = 0; i < 12; ++i) {
    Random random(8, RandomStream::tests, static_cast<uint64_t>(i));
    const vec3 axis = random_direction(random);
    const vec3 side = normalize_or(glm::cross(axis, vec3(0.2f, 0.9f, 0.4f)), {1, 0, 0});
    const vec3 place = 1.5f * random_direction(random);
    scene.instances.push_back({1, mat4x3(axis, 0.5f * side, glm::cross(axis, side), place)});
  }
  const ReceiverSet receivers = random_receivers(2000, 6);
  for (const Light& light : some_lights()) {
    scene.instancing = Instancing::flatten;
    const std::vector<float> flat = visibility_of(scene, light, receivers.view(true));
    scene.instancing = Instancing::instance;
    const std::vector<float> instanced = visibility_of(scene, light, receivers.view(true));
    int different = 0;
    int shadowed = 0;
    for (size_t i = 0; i < flat.size(); ++i) {
      different += flat[i] != instanced[i] ? 1 : 0;
      shadowed += flat[i] == 0 ? 1 : 0;
    }
    EXPECT_LE(different, 2) << "rays through an outline may round either way";
    EXPECT_GT(shadowed, 10);
  }
}

TEST(ShadowMethods, MakeWhatTheyName) {
  const Scene scene = make_empty_sky();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 1);
  EXPECT_EQ(make_shadow(ShadowMethod::none, tracer, cache), nullptr);
  EXPECT_NE(make_shadow(ShadowMethod::ray, tracer, cache), nullptr);
  EXPECT_NE(make_shadow(ShadowMethod::members, tracer, cache), nullptr);
  EXPECT_NE(make_shadow(ShadowMethod::opacity, tracer, cache), nullptr);
  EXPECT_NE(make_shadow(ShadowMethod::volume, tracer, cache), nullptr);
}

}  // namespace
}  // namespace relume

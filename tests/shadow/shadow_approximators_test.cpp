#include <gtest/gtest.h>

#include <numeric>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "shadow/opacity.h"
#include "shadow/traced.h"
#include "shadow/volume.h"
#include "tests/support/receiver_set.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

// What opacity and volume must both keep to.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

enum class Kind { opacity, volume };

std::unique_ptr<VisibilitySource> make_source(Kind kind, const Scene& scene,
                                              const ReceiverSet& receivers) {
  const std::vector<Bounds> boxes{receivers.bounds()};
  if (kind == Kind::opacity) {
    return std::make_unique<OpacityVisibility>(scene, boxes, OpacityParams{.max_texels = 1u << 20});
  }
  return std::make_unique<VolumeVisibility>(scene, boxes, VolumeParams{.max_cells = 1'000'000});
}

Scene make_sky() {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
  add_material(scene, "lambert");
  add_material(scene, "kajiya-kay");
  add_material(scene, "leaf");
  return scene;
}

/// Short strands of all directions within the unit cube around the origin.
void add_strands(Scene& scene, int count, float radius, uint64_t seed) {
  Curves curves;
  curves.offsets.push_back(0);
  for (int i = 0; i < count; ++i) {
    Random random(seed, RandomStream::tests, static_cast<uint64_t>(i));
    const float x = random.uniform(-0.5f, 0.5f);
    const float y = random.uniform(-0.5f, 0.5f);
    const float z = random.uniform(-0.5f, 0.5f);
    const vec3 half = 0.05f * random_direction(random);
    curves.points.emplace_back(vec3(x, y, z) - half, radius);
    curves.points.emplace_back(vec3(x, y, z) + half, radius);
    curves.offsets.push_back(static_cast<uint32_t>(curves.points.size()));
    curves.materials.push_back(1);
  }
  add_shape(scene, std::move(curves));
}

/// The same leaf in many places of the unit cube.
void add_leaves(Scene& scene, int count, float half_size, uint64_t seed) {
  add_shape(scene, make_quad(vec3(0), {half_size, 0, 0}, {0, half_size, 0}, 2));
  const auto prototype = static_cast<uint32_t>(scene.prototypes.size() - 1);
  for (int i = 1; i < count; ++i) {
    Random random(seed, RandomStream::tests, static_cast<uint64_t>(i));
    const vec3 axis = random_direction(random);
    const vec3 side = normalize_or(glm::cross(axis, vec3(0.2f, 0.9f, 0.4f)), {1, 0, 0});
    const float x = random.uniform(-0.5f, 0.5f);
    const float y = random.uniform(-0.5f, 0.5f);
    const float z = random.uniform(-0.5f, 0.5f);
    scene.instances.push_back(
        {prototype, mat4x3(axis, side, glm::cross(axis, side), vec3(x, y, z))});
  }
}

/// Points within a cube of half side `half` around `center`.
ReceiverSet make_receivers(int count, vec3 center, float half, uint64_t seed) {
  ReceiverSet receivers;
  for (int i = 0; i < count; ++i) {
    Random random(seed, RandomStream::tests, static_cast<uint64_t>(i));
    const float x = random.uniform(-half, half);
    const float y = random.uniform(-half, half);
    const float z = random.uniform(-half, half);
    const vec3 n = random_direction(random);
    receivers.add(center + vec3(x, y, z), n, 1e-4f);
  }
  return receivers;
}

double mean(const std::vector<float>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

std::vector<Light> some_lights() {
  return {make_point_light({2, 3, 1}),           make_point_light({0.1f, 0.05f, 0}),
          make_point_light({0.4f, 0.3f, 0.5f}),  make_spot_light({0, 3, 0}, {0, -1, 0}, 20, 40),
          make_directional_light({1, -2, 0.5f}), make_point_light({2e5f, 3e5f, 1e5f}),
          make_point_light({1e14f, 0, 0})};
}

class Approximator : public testing::TestWithParam<Kind> {};

TEST_P(Approximator, SeesEverythingWhereNothingStands) {
  const ReceiverSet receivers = make_receivers(100, vec3(0), 0.5f, 1);
  const Scene scene = make_sky();
  const auto source = make_source(GetParam(), scene, receivers);
  for (const Light& light : some_lights()) {
    for (const float seen : receivers.ask(*source, light)) EXPECT_EQ(seen, 1);
  }
}

TEST_P(Approximator, LetsAsMuchThroughAsRays) {
  // Means over many receivers below, within and around a cloud. Cells a quarter of a leaf wide do
  // not know where leaves end: a tenth is what averaging costs there.
  const double tolerance = GetParam() == Kind::opacity ? 0.03 : 0.11;
  for (const bool leaves : {false, true}) {
    Scene scene = make_sky();
    if (leaves) {
      add_leaves(scene, 1500, 0.02f, 3);
    } else {
      add_strands(scene, 8000, 0.0008f, 3);
    }
    const Tracer tracer(scene);
    TracedVisibility traced(tracer);
    for (const vec3 place : {vec3(0, -0.7f, 0), vec3(0), vec3(0.3f, 0.2f, -0.3f)}) {
      const ReceiverSet receivers = make_receivers(1500, place, 0.2f, 4);
      const auto source = make_source(GetParam(), scene, receivers);
      for (const Light& light : some_lights()) {
        const double expected = mean(receivers.ask(traced, light));
        EXPECT_NEAR(mean(receivers.ask(*source, light)), expected, tolerance)
            << (leaves ? "leaves" : "strands") << " at " << place.x << " " << place.y << ", "
            << label_of(light_type_labels, light.type) << " at " << light.position.x << " "
            << light.position.y;
      }
    }
  }
}

TEST_P(Approximator, StaysWithinZeroAndOne) {
  Scene scene = make_sky();
  add_strands(scene, 2000, 0.004f, 5);
  add_leaves(scene, 300, 0.05f, 6);
  add_shape(scene, make_sphere({0.2f, 0, 0}, 0.1f, 8, 0));
  const ReceiverSet receivers = make_receivers(500, vec3(0), 0.6f, 7);
  const auto source = make_source(GetParam(), scene, receivers);
  std::vector<Light> lights = some_lights();
  for (int i = 0; i < 40; ++i) {
    // On receivers, and a hair's breadth off them.
    const vec3 p(receivers.x[i], receivers.y[i], receivers.z[i]);
    lights.push_back(make_point_light(i % 2 == 0 ? p : p + vec3(1e-6f, 0, 0)));
  }
  for (const Light& light : lights) {
    for (const float seen : receivers.ask(*source, light)) {
      EXPECT_GE(seen, 0);
      EXPECT_LE(seen, 1);
    }
  }
}

TEST_P(Approximator, SolidsAreExact) {
  Scene scene = make_sky();
  add_shape(scene, make_sphere({0, 0, 0}, 0.3f, 24, 0));
  add_shape(scene, make_quad({0.2f, 0.5f, 0}, {0.3f, 0, 0}, {0, 0, 0.2f}, 0));
  const Tracer tracer(scene);
  TracedVisibility traced(tracer);
  const ReceiverSet receivers = make_receivers(2000, vec3(0), 0.9f, 8);
  const auto source = make_source(GetParam(), scene, receivers);
  for (const bool surface : {false, true}) {
    for (const Light& light : some_lights()) {
      const std::vector<float> expected = receivers.ask(traced, light, surface);
      const std::vector<float> seen = receivers.ask(*source, light, surface);
      int different = 0;
      for (size_t i = 0; i < seen.size(); ++i) different += seen[i] != expected[i] ? 1 : 0;
      EXPECT_EQ(different, 0) << label_of(light_type_labels, light.type) << " at "
                              << light.position.x;
      EXPECT_LT(mean(expected), 1) << "something is shadowed";
    }
  }
}

TEST_P(Approximator, WhatIsLitFromBehindAsksWhateverItsNormal) {
  Scene scene = make_sky();
  add_shape(scene, make_sphere({0, 0, 0}, 0.3f, 24, 0));
  const Tracer tracer(scene);
  TracedVisibility traced(tracer);
  const ReceiverSet receivers = make_receivers(500, {0, -0.7f, 0}, 0.15f, 14);
  const auto source = make_source(GetParam(), scene, receivers);
  const Light light = make_point_light({0, 3, 0});
  for (VisibilitySource* each : {static_cast<VisibilitySource*>(&traced), source.get()}) {
    each->prepare(light);
    std::vector<float> visibility(receivers.weight.size());
    each->visibility(receivers.view(true, true), visibility.data());
    EXPECT_LT(mean(visibility), 0.01) << "all lie in the shadow";
    each->visibility(receivers.view(true, false), visibility.data());
    EXPECT_NEAR(mean(visibility), 0.5, 0.1)
        << "half of them turn away, and light cannot light them";
  }
}

TEST_P(Approximator, SpotsOutsideTheirConeAskNothing) {
  Scene scene = make_sky();
  add_strands(scene, 3000, 0.01f, 9);
  const ReceiverSet receivers = make_receivers(400, {0, -0.7f, 0}, 0.2f, 10);
  const auto source = make_source(GetParam(), scene, receivers);
  EXPECT_LT(mean(receivers.ask(*source, make_spot_light({0, 3, 0}, {0, -1, 0}, 20, 40))), 0.9);
  for (const float seen : receivers.ask(*source, make_spot_light({0, 3, 0}, {0, 1, 0}, 20, 40))) {
    EXPECT_EQ(seen, 1);
  }
}

TEST_P(Approximator, IsBitEqualForAnyThreadCount) {
  Scene scene = make_sky();
  add_strands(scene, 9000, 0.001f, 11);
  add_leaves(scene, 200, 0.03f, 12);
  add_shape(scene, make_sphere({0.2f, 0, 0}, 0.1f, 8, 0));
  const ReceiverSet receivers = make_receivers(800, vec3(0), 0.6f, 13);
  std::vector<std::vector<float>> first;
  for (const int threads : {1, 2, 7}) {
    set_thread_count(threads);
    const auto source = make_source(GetParam(), scene, receivers);
    const std::vector<Light> lights = some_lights();
    for (size_t i = 0; i < lights.size(); ++i) {
      const std::vector<float> seen = receivers.ask(*source, lights[i]);
      if (threads == 1) first.push_back(seen);
      EXPECT_EQ(seen, first[i]) << threads << " threads";
    }
  }
  set_thread_count(0);
}

TEST_P(Approximator, HoldsAtAnyScale) {
  Scene scene = make_sky();
  add_strands(scene, 4000, 0.001f, 14);
  add_leaves(scene, 200, 0.03f, 15);
  scene.lights = {make_point_light({2, 3, 1}), make_point_light({0.1f, 0.05f, 0}),
                  make_directional_light({1, -2, 0.5f})};
  const ReceiverSet receivers = make_receivers(500, vec3(0), 0.6f, 16);
  const auto source = make_source(GetParam(), scene, receivers);
  for (const float scale : {1e-6f, 1e-3f, 1e3f, 1e6f}) {
    const Scene moved = move_scene(scene, scale, vec3(0));
    const ReceiverSet scaled = receivers.scaled(scale);
    const auto other = make_source(GetParam(), moved, scaled);
    for (size_t l = 0; l < scene.lights.size(); ++l) {
      const std::vector<float> a = receivers.ask(*source, scene.lights[l]);
      const std::vector<float> b = scaled.ask(*other, moved.lights[l]);
      double difference = 0;
      for (size_t i = 0; i < a.size(); ++i) difference += std::abs(double{a[i]} - b[i]);
      EXPECT_LT(difference / static_cast<double>(a.size()), 5e-3) << scale << " light " << l;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, Approximator, testing::Values(Kind::opacity, Kind::volume),
                         [](const auto& kind) {
                           return kind.param == Kind::opacity ? "opacity" : "volume";
                         });

TEST(OpacityVisibility, EveryOccluderOnlyDarkens) {
  const ReceiverSet receivers = make_receivers(600, vec3(0), 0.6f, 17);
  for (const Light& light : some_lights()) {
    Scene scene = make_sky();
    add_strands(scene, 500, 0.002f, 18);
    add_leaves(scene, 4, 0.5f, 18);  // bounds that later ones do not leave
    std::vector<float> before;
    for (uint64_t step = 0; step < 4; ++step) {
      if (step > 0) add_strands(scene, 300, 0.004f, 18 + step);
      const auto source = make_source(Kind::opacity, scene, receivers);
      const std::vector<float> now = receivers.ask(*source, light);
      for (size_t i = 0; i < before.size(); ++i) EXPECT_LE(now[i], before[i]) << i;
      before = now;
    }
  }
}

TEST(VolumeVisibility, EveryOccluderOnlyDarkens) {
  // Up to the rounding of moments, 1 / 254 of a cell's area.
  const ReceiverSet receivers = make_receivers(600, vec3(0), 0.6f, 19);
  Bounds region;
  region.extend(vec3(-0.7f));
  region.extend(vec3(0.7f));
  for (const Light& light : some_lights()) {
    Scene scene = make_sky();
    std::vector<float> before;
    for (uint64_t step = 0; step < 4; ++step) {
      add_strands(scene, 300, 0.004f, 20 + step);
      VolumeVisibility source(scene, {receivers.bounds()}, {.max_cells = 500'000}, region);
      const std::vector<float> now = receivers.ask(source, light);
      for (size_t i = 0; i < before.size(); ++i) EXPECT_LE(now[i], before[i] + 0.01f) << i;
      before = now;
    }
  }
}

}  // namespace
}  // namespace relume

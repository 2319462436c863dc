#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/study/ray_memory.h"

namespace relume {
namespace {

constexpr int point_count = 40;

/// Points in a box around the spheres, with and without normals.
struct Points {
  std::vector<float> values = std::vector<float>(8 * point_count);

  explicit Points(uint64_t seed) {
    Random random(seed, RandomStream::planning, 0);
    for (float& value : values) value = 4 * random.uniform() - 2;
    for (int i = 0; i < point_count; ++i) {
      values[6 * point_count + i] = 1e-4f;
      values[7 * point_count + i] = i % 5 == 0 ? 0.0f : 0.1f;
    }
  }
  Receivers receivers(bool on_surface) const {
    Receivers receivers;
    receivers.count = point_count;
    for (int c = 0; c < 3; ++c) {
      receivers.position[c] = &values[c * point_count];
      if (on_surface) receivers.normal[c] = &values[(3 + c) * point_count];
    }
    receivers.bias = &values[6 * point_count];
    receivers.weight = &values[7 * point_count];
    return receivers;
  }
};

class RayMemoryTest : public testing::Test {
 protected:
  const Scene scene_ = load_scene("spheres", shader_table(), {});
  const Tracer tracer_{scene_};
  RayTargets targets_{tracer_};
  std::vector<Light> lights_;

  void SetUp() override {
    for (uint64_t i = 0; i < 3; ++i) {
      lights_.push_back(
          interpolate_light(scene_.representative_low, scene_.representative_high, 1, i));
      targets_.add(lights_.back());
    }
  }
};

TEST_F(RayMemoryTest, AnswersAsTheRaysDo) {
  RayMemory memory(targets_);
  int hidden = 0;
  for (int round = 0; round < 2; ++round) {
    for (const uint64_t seed : {1, 2, 3, 4}) {
      const Points points(seed);
      for (const bool on_surface : {false, true}) {
        for (size_t light = 0; light < lights_.size(); ++light) {
          std::vector<float> expected(point_count), found(point_count);
          targets_.rays(light).visibility(points.receivers(on_surface), expected.data());
          memory.visibility(light, points.receivers(on_surface), found.data());
          EXPECT_EQ(found, expected) << "seed " << seed << " light " << light;
          for (const float visibility : found) hidden += visibility == 0;
        }
      }
    }
  }
  EXPECT_GT(hidden, 0);
}

TEST_F(RayMemoryTest, TracesEachReceiverOnceForALight) {
  RayMemory memory(targets_);
  const Points points(1);
  std::vector<float> found(point_count);
  memory.visibility(0, points.receivers(true), found.data());
  EXPECT_EQ(memory.traced_count(), point_count);
  Receivers some = points.receivers(true);
  some.count = point_count / 2;
  memory.visibility(0, some, found.data());
  EXPECT_EQ(memory.traced_count(), point_count);
  memory.visibility(1, some, found.data());
  EXPECT_EQ(memory.traced_count(), point_count + point_count / 2);
}

TEST_F(RayMemoryTest, HasASourceForEveryLightThatCastsAShadow) {
  lights_[1].casts_shadow = false;
  const LightSet set = make_light_set(lights_, 1);
  RayMemory memory(targets_);
  const std::vector<const VisibilitySource*> sources = memory.sources(set);
  ASSERT_EQ(sources.size(), static_cast<size_t>(set.columns()));
  for (size_t column = 0; column < sources.size(); ++column) {
    EXPECT_EQ(sources[column] != nullptr, !set.padding[column] && set.lights[column].casts_shadow);
  }
}

}  // namespace
}  // namespace relume

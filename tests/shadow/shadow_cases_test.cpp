#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/relight/pixel_visibility.h"
#include "shadow/automatic.h"
#include "shadow/shadow.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

// Lights and geometry at their extremes, for every method, against a ray from every sample.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// Strands on a part of a sphere that faces the camera, on a plane behind it.
Scene make_hairy_ball() {
  Scene scene = make_plane_scene(2, vec3(0.5f), 40, 40);
  add_shape(scene, make_sphere({0, 0, 0.5f}, 0.4f, 24, 0));
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Curves curves;
  curves.offsets.push_back(0);
  for (uint64_t i = 0; i < 3000; ++i) {
    Random random(1, RandomStream::tests, i);
    const vec3 out = random_direction(random);
    const vec3 tip = normalize_or(out + 0.4f * random_direction(random), out);
    for (const auto& [at, reach] : {std::pair(out, 0.4f), std::pair(tip, 0.55f)}) {
      curves.points.emplace_back(vec3(0, 0, 0.5f) + reach * at, 0.004f);
    }
    curves.offsets.push_back(static_cast<uint32_t>(curves.points.size()));
    curves.materials.push_back(hair);
  }
  add_shape(scene, std::move(curves));
  return scene;
}

/// Many copies of a leaf over a plane.
Scene make_leaves(bool cut_out) {
  Scene scene = make_plane_scene(2, vec3(0.5f), 40, 40);
  const uint32_t leaf = add_material(scene, "leaf");
  if (cut_out) {
    // Every second column of a leaf is there.
    Texture mask;
    mask.width = 2;
    mask.height = 2;
    mask.texels = {255, 255, 255, 255, 0, 0, 0, 0, 255, 255, 255, 255, 0, 0, 0, 0};
    scene.textures.push_back(mask);
    scene.materials[leaf].alpha_texture = 0;
  }
  add_shape(scene, make_quad(vec3(0), {0.12f, 0, 0}, {0, 0.12f, 0}, leaf));
  const auto prototype = static_cast<uint32_t>(scene.prototypes.size() - 1);
  for (uint64_t i = 0; i < 60; ++i) {
    Random random(2, RandomStream::tests, i);
    const vec3 axis = random_direction(random);
    const vec3 side = normalize_or(glm::cross(axis, vec3(0.2f, 0.9f, 0.4f)), {1, 0, 0});
    const float x = random.uniform(-1, 1);
    const float y = random.uniform(-1, 1);
    const float z = random.uniform(0.2f, 0.8f);
    scene.instances.push_back(
        {prototype, mat4x3(axis, side, glm::cross(axis, side), vec3(x, y, z))});
  }
  return scene;
}

class ShadowCase : public testing::TestWithParam<ShadowMethod> {
 protected:
  /// Mean over the picture of visibility, by the method and by rays.
  struct Means {
    double seen = 0;
    double traced = 0;
  };

  Means measure(const Scene& scene, const Light& light, std::string_view name) const {
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 4);
    const auto mean = [&](ShadowMethod method) {
      const auto source = make_shadow(method, tracer, cache);
      source->prepare(light);
      double sum = 0;
      const std::vector<float> pixels = pixel_visibility(cache, *source);
      for (const float pixel : pixels) {
        EXPECT_GE(pixel, 0) << name;
        EXPECT_LE(pixel, 1) << name;
        sum += pixel;
      }
      return sum / static_cast<double>(pixels.size());
    };
    return {mean(GetParam()), mean(ShadowMethod::ray)};
  }

  void expect_near_rays(const Scene& scene, const Light& light, std::string_view name) const {
    const Means means = measure(scene, light, name);
    EXPECT_NEAR(means.seen, means.traced, tolerance()) << name;
  }

  /// Volume's cells blur leaves: an eighth of the light is what that may cost.
  double tolerance() const { return GetParam() == ShadowMethod::volume ? 0.12 : 0.03; }
};

TEST_P(ShadowCase, HairOnASolidFromAllSides) {
  const Scene scene = make_hairy_ball();
  const vec3 center(0, 0, 0.5f);
  expect_near_rays(scene, make_point_light({1, 1, 2.5f}), "beside");
  expect_near_rays(scene, make_point_light({3, 0, 0.1f}), "grazing");
  expect_near_rays(scene, make_point_light(center + vec3(0.1f, 0.1f, 0.48f)), "inside the hair");
  expect_near_rays(scene, make_point_light(center + vec3(0, 0, 0.405f)), "very near the solid");
  expect_near_rays(scene, make_point_light({1e7f, 2e7f, 3e7f}), "very far");
  expect_near_rays(scene, make_directional_light({-0.4f, 0.3f, -1}), "directional");
  expect_near_rays(scene, make_spot_light({0.5f, 0, 3}, {-0.1f, 0, -1}, 10, 30), "spot");
}

TEST_P(ShadowCase, ASolidHidesHair) {
  Scene scene = make_hairy_ball();
  add_shape(scene, make_quad({0, 0, 1.6f}, {0.5f, 0, 0}, {0, 0.5f, 0}, 0));
  scene.camera = make_camera({3, 0, 1}, {0, 0, 0.5f}, 40, {0, 0, 1});
  const Means means = measure(scene, make_point_light({0, 0, 3}), "a solid over hair");
  EXPECT_NEAR(means.seen, means.traced, tolerance());
}

TEST_P(ShadowCase, SpotsOutsideTheirConeSeeEverything) {
  const Means means =
      measure(make_hairy_ball(), make_spot_light({0, 0, 3}, {0, 0, 1}, 10, 30), "turned away");
  EXPECT_EQ(means.seen, 1);
}

TEST_P(ShadowCase, InstancedLeavesWithAndWithoutMasks) {
  for (const bool cut_out : {false, true}) {
    const Scene scene = make_leaves(cut_out);
    // Masks are averages to volume, and opacity draws leaves whole.
    if (cut_out && GetParam() == ShadowMethod::opacity) continue;
    const Light light =
        cut_out ? make_directional_light({0.2f, -0.3f, -1}) : make_point_light({1, 1, 3});
    expect_near_rays(scene, light, cut_out ? "cut-outs" : "leaves");
  }
}

TEST_P(ShadowCase, LightsAmongLeavesSeeNoSeams) {
  // The planes at 45 degrees between the views of a light in the middle cross the plane below in a
  // square: its rim is shadowed as its inside is.
  const Scene scene = make_leaves(false);
  const Light light = make_point_light({0.05f, 0.02f, 0.9f});
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  const auto map = [&](ShadowMethod method) {
    const auto source = make_shadow(method, tracer, cache);
    source->prepare(light);
    return pixel_visibility(cache, *source);
  };
  const std::vector<float> seen = map(GetParam());
  const std::vector<float> traced = map(ShadowMethod::ray);
  const CameraRays rays(scene.camera, 40, 40);
  double rim = 0;
  double count = 0;
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 40; ++x) {
      const vec3 way = rays.direction(vec2(x, y) + 0.5f);
      const vec3 at = rays.eye() - way * (rays.eye().z / way.z);
      const float off = max_abs_component(vec3(vec2(at - light.position), 0)) / light.position.z;
      if (std::abs(off - 1) > 0.1f) continue;
      rim += seen[static_cast<size_t>(40 * y + x)] - traced[static_cast<size_t>(40 * y + x)];
      ++count;
    }
  }
  ASSERT_GT(count, 50);
  EXPECT_NEAR(rim / count, 0, 2 * tolerance());
}

INSTANTIATE_TEST_SUITE_P(Methods, ShadowCase,
                         testing::Values(ShadowMethod::members, ShadowMethod::coverage,
                                         ShadowMethod::opacity, ShadowMethod::volume,
                                         ShadowMethod::automatic),
                         [](const auto& method) {
                           return std::string(label_of(shadow_method_labels, method.param));
                         });

}  // namespace
}  // namespace relume

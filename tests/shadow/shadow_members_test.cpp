#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/samples/sample_scene.h"
#include "core/shade/shaders.h"
#include "shadow/coverage.h"
#include "shadow/members.h"
#include "shadow/shadow.h"
#include "tests/support/expect_error.h"
#include "tests/support/merged_cache.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// Strands above a floor.
Scene make_strand_scene() {
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0.4f, 0}, 40), 32, 32);
  const uint32_t floor = add_material(scene, "lambert");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_quad(vec3(0), {0, 0, 3}, {3, 0, 0}, floor));
  for (int i = 0; i < 60; ++i) {
    const float x = -1.2f + 0.04f * static_cast<float>(i);
    add_shape(scene, make_strand({x, 0, 0}, {x + 0.1f, 0.9f, 0.1f}, 0.006f, 4, hair));
  }
  return scene;
}

double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

TEST(MemberVisibility, FromAllMembersIsThatOfAllSamples) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const Light light = make_point_light({2, 3, 2});
  const RelightCache all = make_full_cache(scene, tracer, 16);
  MemberVisibility exact(tracer, all, max_members);
  const std::vector<double> expected = pixel_visibility(all, exact, light);
  const RelightCache merged = make_merged_cache(scene, tracer, 16, max_members);
  MemberVisibility members(tracer, merged, max_members);
  // Rounding of positions lets single rays pass on the other side of a strand.
  EXPECT_LT(mean_difference(pixel_visibility(merged, members, light), expected), 5e-4);
  double last = mean_difference(pixel_visibility(merged, members, light), expected);
  for (const int rays : {4, 1}) {
    MemberVisibility fewer(tracer, merged, rays);
    const double error = mean_difference(pixel_visibility(merged, fewer, light), expected);
    EXPECT_GT(error, last) << rays << " rays";
    last = error;
  }
}

TEST(MemberVisibility, OfSamplesIsRay) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache all = make_full_cache(scene, tracer, 4);
  const std::vector<Light> lights = {make_point_light({2, 3, 2})};
  const auto ray = make_shadow(ShadowMethod::ray, tracer, all);
  const auto members = make_shadow(ShadowMethod::members, tracer, all);
  EXPECT_EQ(render_frame(all, lights, ray.get()).pixels,
            render_frame(all, lights, members.get()).pixels);
}

TEST(MemberVisibility, DoesNotDependOnTheThreads) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache merged = make_merged_cache(scene, tracer, 9, 5);
  const std::vector<Light> lights = {make_point_light({2, 3, 2})};
  std::vector<float> first;
  for (const int threads : {1, 2, 3, 8}) {
    set_thread_count(threads);
    MemberVisibility members(tracer, merged, 3);
    const Image frame = render_frame(merged, lights, &members);
    if (first.empty()) first = frame.pixels;
    EXPECT_EQ(frame.pixels, first) << threads << " threads";
  }
  set_thread_count(0);
}

TEST(Coverage, WithoutMembersAWideFootprintIsOneSample) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const Light light = make_point_light({2, 3, 2});
  const RelightCache all = make_merged_cache(scene, tracer, 16, max_members);
  const RelightCache none = make_merged_cache(scene, tracer, 16, 0);
  const RelightCache samples = make_full_cache(scene, tracer, 16);
  MemberVisibility exact(tracer, samples, 1);
  const std::vector<double> expected = pixel_visibility(samples, exact, light);
  CoverageVisibility of_all(tracer, all);
  CoverageVisibility of_none(tracer, none);
  MemberVisibility ray(tracer, none, 1);
  const double error = mean_difference(pixel_visibility(none, of_none, light), expected);
  EXPECT_GT(error, mean_difference(pixel_visibility(all, of_all, light), expected));
  EXPECT_LT(error, mean_difference(pixel_visibility(none, ray, light), expected));
  // A footprint over all of a pixel's strands would reach far more than its samples do.
  EXPECT_LT(of_none.stats().tests, of_all.stats().tests);
}

TEST(MemberVisibility, NeedsMembers) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache merged = make_merged_cache(scene, tracer, 4, 0);
  EXPECT_ERROR(make_shadow(ShadowMethod::members, tracer, merged), ErrorKind::input,
               "keeps no members");
  EXPECT_NE(make_shadow(ShadowMethod::members, tracer, merged, {.member_rays = 1}), nullptr);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "shadow/traced.h"
#include "tests/support/receiver_set.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "viewer/study/lit_visibility.h"
#include "viewer/study/shadow_study.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

TEST(VisibilityError, SplitsAnOffsetFromAChequer) {
  constexpr int width = 40;
  std::vector<float> truth(width * width, 0.5f);
  const std::vector<float> counts(truth.size(), 1.0f);
  std::vector<float> offset(truth.size(), 0.6f);
  const VisibilityError low = compare_visibility(offset, truth, counts, width);
  EXPECT_NEAR(low.mae, 0.1, 1e-6);
  EXPECT_NEAR(low.bias, 0.1, 1e-6);
  EXPECT_NEAR(low.noise, 0, 1e-6);
  std::vector<float> chequer = truth;
  for (int i = 0; i < width * width; ++i) chequer[i] += (i + i / width) % 2 == 0 ? 0.1f : -0.1f;
  const VisibilityError high = compare_visibility(chequer, truth, counts, width);
  EXPECT_NEAR(high.mae, 0.1, 1e-6);
  EXPECT_NEAR(high.noise, 0.1, 1e-3);
  EXPECT_LT(high.bias, 2e-3);
}

TEST(VisibilityError, PixelsThatDoNotCountReachNothing) {
  constexpr int width = 20;
  std::vector<float> truth(width * width, 0.25f);
  std::vector<float> map(truth.size(), 0.5f);
  std::vector<float> counts(truth.size(), 1.0f);
  for (int i = 0; i < width * width; ++i) {
    if (i % width < 7) counts[i] = 0;
    if (i % width < 7) map[i] = 1e6f;
  }
  const VisibilityError error = compare_visibility(map, truth, counts, width);
  EXPECT_NEAR(error.mae, 0.25, 1e-6);
  EXPECT_NEAR(error.bias, 0.25, 1e-6);
  EXPECT_NEAR(error.noise, 0, 1e-6);
  const VisibilityError none =
      compare_visibility(map, truth, std::vector<float>(truth.size(), 0.0f), width);
  EXPECT_EQ(none.mae, 0);
}

TEST(VisibilityError, BlurKeepsTheMeanOfAnImpulse) {
  constexpr int width = 41;
  std::vector<double> impulse(width * width, 0.0);
  impulse[20 * width + 20] = 1;
  const std::vector<float> counts(impulse.size(), 1.0f);
  const std::vector<double> blurred = blur_masked(impulse, counts, width, 3);
  EXPECT_NEAR(std::accumulate(blurred.begin(), blurred.end(), 0.0), 1, 1e-9);
  EXPECT_NEAR(blurred[20 * width + 20], 1 / (2 * 3.14159265 * 9), 1e-4);
  EXPECT_NEAR(blurred[20 * width + 23] / blurred[20 * width + 20], std::exp(-0.5), 1e-9);
}

TEST(StudyWindow, LiesOnTilesWithinThePicture) {
  for (const int width : {30, 96, 100, 513}) {
    for (const int size : {1, 16, 40, 96, 1000}) {
      const StudyWindow window = make_window(size, 0.5f * vec2(width, 64), width, 64);
      EXPECT_EQ(window.x0 % tile_size, 0);
      EXPECT_GE(window.x0, 0);
      EXPECT_GT(window.width, 0);
      EXPECT_LE(window.x0 + window.width, width);
      EXPECT_GE(window.width, std::min(size, width) - tile_size) << width << " " << size;
    }
  }
  const StudyWindow whole = make_window(0, vec2(0), 33, 20);
  EXPECT_EQ(whole.width, 33);
  EXPECT_EQ(whole.height, 20);
}

/// A quad over half of a plane.
Scene make_covered_plane() {
  Scene scene = make_plane_scene(5, vec3(0.5f), 64, 48);
  add_shape(scene, make_quad({1, 0, 0.4f}, {1, 0, 0}, {0, 5, 0}, 0));
  scene.name = "covered plane";
  return scene;
}

TEST(StudyLights, StandAroundTheFocus) {
  const Scene scene = make_covered_plane();
  const Tracer tracer(scene);
  const ViewFocus focus = find_focus(scene, tracer, 64, 48);
  ASSERT_FALSE(focus.empty);
  EXPECT_LT(glm::length(focus.center), 0.6f);
  EXPECT_GT(focus.radius, 0.5f);
  EXPECT_GT(focus.pixel, 0);
  const auto lights = make_study_lights(scene, focus, 3);
  ASSERT_EQ(lights.size(), 5u);
  for (const StudyLight& light : lights) {
    ASSERT_EQ(light.path.size(), 4u);
    for (size_t i = 0; i < light.path.size(); ++i) {
      EXPECT_NO_THROW(validate_light(light.path[i], light.name));
      if (i == 0) continue;
      EXPECT_FALSE(same_layer(light.path[i], light.path[i - 1])) << light.name;
    }
  }
}

TEST(ShadowTruth, OfAnUnshadowedPlaneIsOne) {
  const Scene scene = make_plane_scene(5, vec3(0.5f), 32, 32);
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 32, 32, 4, 1);
  const StudyLight light{"above", {make_point_light({0, 0, 3}, 9)}};
  TrialLog log;
  const ShadowTruth truth =
      trace_truth(view, make_window(0, vec2(0), 32, 32), {&light, 1}, log, {});
  for (size_t i = 0; i < truth.covered.size(); ++i) {
    EXPECT_EQ(truth.covered[i], 1);
    EXPECT_EQ(truth.steps[0][0][i], 1);
    EXPECT_GT(truth.frames[0].pixels[3 * i], 0);
  }
}

TEST(LitVisibility, IsZeroWhereNoLightReaches) {
  ReceiverSet receivers;
  receivers.add({0, 0, 0}, {0, 0, 1}, 1e-4f);
  receivers.add({0, 0, 0}, {0, 0, -1}, 1e-4f);  // turned away
  receivers.add({9, 0, 0}, {0, 0, 1}, 1e-4f);   // outside the cone
  const Scene scene = make_plane_scene(0.1f, vec3(0.5f), 8, 8);
  const Tracer tracer(scene);
  TracedVisibility traced(tracer);
  const auto seen = [&](const Light& light, bool surface, bool from_behind) {
    traced.prepare(light);
    std::vector<float> visibility(3);
    LitVisibility(traced, light)
        .visibility(receivers.view(surface, from_behind), visibility.data());
    return visibility;
  };
  const Light spot = make_spot_light({0, 0, 3}, {0, 0, -1}, 20, 30);
  EXPECT_EQ(seen(spot, true, false), (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(seen(spot, true, true)[2], 0) << "outside the cone";
  EXPECT_EQ(seen(spot, false, false), (std::vector<float>{1, 1, 0})) << "strands have no back";
  EXPECT_EQ(seen(make_point_light({0, 0, 3}), true, false), (std::vector<float>{1, 0, 1}));
  EXPECT_EQ(seen(make_directional_light({0, 0, 1}), true, false)[0], 0);
}

TEST(ShadowTruth, FadesAtTheTerminatorOfASphere) {
  // Lit from the side, the half that turns away is dark: no pixel's neighbour jumps from the
  // shadow of the sphere to full visibility.
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 30), 48, 48);
  add_shape(scene, make_sphere(vec3(0), 1, 48, add_material(scene, "lambert")));
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 48, 48, 16, 1);
  const StudyLight light{"side", {make_directional_light({-1, 0, 0})}};
  TrialLog log;
  const ShadowTruth truth =
      trace_truth(view, make_window(0, vec2(0), 48, 48), {&light, 1}, log, {});
  for (int x = 12; x < 36; ++x) {
    const float seen = truth.steps[0][0][24 * 48 + x];
    if (x < 22 || x > 25) {
      EXPECT_EQ(seen, x < 22 ? 0 : 1) << x;
    }
  }
}

TEST(ShadowStudy, AllSamplesTracedAreTheirOwnReference) {
  const Scene scene = make_covered_plane();
  const Tracer tracer(scene);
  ShadowStudyParams params;
  params.trials = {{ShadowMethod::none, ReductionMethod::kmeans, 2},
                   {ShadowMethod::ray, ReductionMethod::kmeans, 2}};
  params.spp = 9;
  params.truth_spp = 64;
  params.window = 32;
  params.keep_maps = true;
  TrialLog log;
  const ShadowStudy study = study_shadows(scene, tracer, params, log, {});
  ASSERT_EQ(study.figures.size(), 3u);
  EXPECT_EQ(study.figures[0].trial.method, ReductionMethod::all);
  EXPECT_NEAR(study.figures[0].average_records, 9, 1e-9);
  for (const ShadowLightFigure& light : study.figures[0].lights) {
    EXPECT_EQ(light.error_of_all, 0) << light.light;
    EXPECT_LT(light.visibility.mae, 0.03) << light.light;
  }
  const ShadowLightFigure none = mean_figure(study.figures[1]);
  const ShadowLightFigure ray = mean_figure(study.figures[2]);
  EXPECT_GT(none.visibility.mae, 2 * ray.visibility.mae);
  EXPECT_GT(none.error_of_all, ray.error_of_all);
  const ShadowLightFigure& overhead = study.figures[1].lights[2];
  EXPECT_NEAR(overhead.visibility.mae, 1 - overhead.truth_visibility, 1e-6) << "without shadows";
  EXPECT_NEAR(none.flicker, none.truth_change, 1e-12) << "a frozen shadow";
}

TEST(ShadowStudy, DoesNotDependOnThreads) {
  const Scene scene = make_covered_plane();
  const Tracer tracer(scene);
  ShadowStudyParams params;
  params.trials = {{ShadowMethod::ray, ReductionMethod::strong_kmeans, 2}};
  params.spp = 4;
  params.truth_spp = 16;
  params.steps = 1;
  set_thread_count(1);
  TrialLog log;
  TrialLog other_log;
  const ShadowStudy one = study_shadows(scene, tracer, params, log, {});
  set_thread_count(4);
  const ShadowStudy four = study_shadows(scene, tracer, params, other_log, {});
  set_thread_count(0);
  for (size_t f = 0; f < one.figures.size(); ++f) {
    for (size_t l = 0; l < one.lights.size(); ++l) {
      const ShadowLightFigure& a = one.figures[f].lights[l];
      const ShadowLightFigure& b = four.figures[f].lights[l];
      EXPECT_EQ(a.visibility.mae, b.visibility.mae);
      EXPECT_EQ(a.flicker, b.flicker);
      EXPECT_EQ(a.error, b.error);
    }
  }
}

}  // namespace
}  // namespace relume

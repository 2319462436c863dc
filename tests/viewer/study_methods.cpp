#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/image/metrics.h"
#include "core/relight/relight.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/study/method_study.h"

namespace relume {
namespace {

constexpr int size_px = 48;

MethodStudyParams make_small_params() {
  MethodStudyParams params;
  params.trials = {{ReductionMethod::all, 9, 9, {}}, {ReductionMethod::kmeans, 9, 2, {}}};
  params.shadows = {ShadowMethod::none, ShadowMethod::ray};
  params.lights = 3;
  params.width = size_px;
  params.height = size_px;
  params.reference_spp = 9;
  params.seed = 5;
  return params;
}

/// The picture as the renderer makes it.
Image relight_picture(const Scene& scene, const Tracer& tracer, const MethodTrial& trial,
                      const Light& light, ShadowMethod shadow) {
  PrepareParams params;
  params.spp = trial.spp;
  params.reduction.method = trial.method;
  params.reduction.records = trial.records;
  params.reduction.seed = 5;
  params.training = {.lights = trial.training_lights, .shadows = trial.train_shadows, .seed = 5};
  params.width = params.height = size_px;
  const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
  RelightState state = make_relight_state(cache);
  const auto source = shadow == ShadowMethod::none ? nullptr : make_shadow(shadow, tracer, cache);
  relight(state, {&light, 1}, source.get());
  return state.frame;
}

TEST(MethodStudy, ErrorsAreThoseOfThePicturesThatTheRendererMakes) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Tracer tracer(scene);
  MethodStudyParams params = make_small_params();
  params.training.seed = 5;
  params.trials.push_back({ReductionMethod::light_metric_4, 9, 2, {}, 6, false});
  params.trials.push_back({ReductionMethod::light_metric_4, 9, 2, {}, 6, true});
  params.trials.push_back({ReductionMethod::light_metric_5, 9, 2, {}, 3, true});
  TrialLog log;
  const auto figures = study_methods(scene, tracer, params, log, {});
  ASSERT_EQ(figures.size(), 10u);
  for (const MethodFigure& figure : figures) {
    for (size_t i = 0; i < figure.errors.size(); ++i) {
      const Light light =
          interpolate_light(scene.representative_low, scene.representative_high, params.seed, i);
      const ImageError expected =
          compare_images(relight_picture(scene, tracer, figure.trial, light, figure.shadow),
                         relight_picture(scene, tracer, params.trials[0], light, figure.shadow));
      const double sum = figure.errors[i] * static_cast<double>(figure.covered_pixels);
      EXPECT_NEAR(sum, expected.error_image * static_cast<double>(expected.pixels),
                  1e-3 * sum + 1e-4)
          << label_of(shadow_method_labels, figure.shadow) << " light " << i;
    }
  }
  EXPECT_EQ(figures[0].error, 0) << "all samples against themselves";
  EXPECT_EQ(figures[1].error, 0);
  EXPECT_GT(figures[2].error, 1e-5);
  EXPECT_LT(figures[1].reference_mean, 0.95 * figures[0].reference_mean) << "shadows darken";
  EXPECT_NE(figures[4].error, figures[6].error) << "trained without and with shadows";
}

TEST(MethodStudy, IsTheSameFromTheLogAndOnAnyNumberOfThreads) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Tracer tracer(scene);
  const MethodStudyParams params = make_small_params();
  TrialLog log;
  set_thread_count(1);
  const auto one = study_methods(scene, tracer, params, log, {});
  const auto again = study_methods(scene, tracer, params, log, {});
  set_thread_count(0);
  TrialLog other;
  const auto all = study_methods(scene, tracer, params, other, {});
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].errors, again[i].errors) << i;
    EXPECT_EQ(one[i].errors, all[i].errors) << i;
    EXPECT_EQ(one[i].reference_mean, all[i].reference_mean) << i;
  }
}

}  // namespace
}  // namespace relume

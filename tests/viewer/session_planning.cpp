// The cost of a record and the lights of a method, for a whole view.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/base/parallel.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "reduction/pixel_reducer.h"
#include "viewer/session/method_training.h"
#include "viewer/session/prepare.h"
#include "viewer/session/record_planning.h"

namespace relume {
namespace {

/// A view of the built-in hair.
struct HairView {
  Scene scene = load_scene("hair", shader_table());
  Tracer tracer{scene};
  ViewSampler view;

  HairView(int width, int height)
      : view(make_view_sampler(scene, tracer, width, height, 9, /*seed=*/2)) {}

  ReductionParams params(ReductionMethod method, int records) const {
    ReductionParams params;
    params.method = method;
    params.records = records;
    params.seed = 2;
    params.scene_radius = tracer.bounds().radius();
    return params;
  }
  float plan(const ReductionParams& params, const RecordBudget& budget) const {
    return plan_records(scene, view, params, {}, budget, {}).record_cost;
  }
};

/// What came out over all covered pixels.
struct Outcome {
  double records = 0;  ///< mean
  double error = 0;    ///< mean of the predicted ones
  double value = 0;    ///< mean, under the validation lights
};

Outcome reduce_view(const HairView& hair, ReductionParams params) {
  const auto lights = make_method_lights(hair.scene, hair.view, params, {});
  Outcome outcome;
  double covered = 0;
  for (int i = 0; i < tile_count(hair.view); ++i) {
    const SampleTile samples = sample_tile(hair.view, i);
    const SampleTile records =
        reduce_tile(samples, hair.view.types.types, params, hair.view.width, lights->lights());
    outcome.records += static_cast<double>(records.row_count());
    outcome.error +=
        std::accumulate(records.predicted_error.begin(), records.predicted_error.end(), 0.0);
    PixelReducer reducer(hair.view.types.types, params, lights->lights());
    for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
      reducer.load(samples, pixel, 0);
      covered += reducer.sample_count() > 0;
      outcome.value += double{reducer.error_curve(/*cost=*/1e30f).value};
    }
  }
  return {outcome.records / covered, outcome.error / covered, outcome.value / covered};
}

TEST(PlanRecordCost, IsBitEqualForAnyThreadCount) {
  const HairView hair(40, 36);
  for (const ReductionMethod method :
       {ReductionMethod::strong_kmeans, ReductionMethod::light_fit_fast}) {
    for (const RecordBudget& budget :
         {RecordBudget{.average_records = 2}, RecordBudget{.target_error = 0.05f}}) {
      const ReductionParams params = hair.params(method, 6);
      set_thread_count(1);
      const float alone = hair.plan(params, budget);
      set_thread_count(3);
      const float together = hair.plan(params, budget);
      set_thread_count(0);
      EXPECT_GT(alone, 0);
      EXPECT_EQ(alone, together);
    }
  }
}

TEST(PlanRecordCost, KeepsAnAverageOfASmallViewExactly) {
  const HairView hair(72, 56);
  ReductionParams params = hair.params(ReductionMethod::strong_kmeans, 9);
  for (const float average : {0.5f, 1.5f, 3.0f}) {
    params.record_cost = hair.plan(params, {.average_records = average});
    const double records = reduce_view(hair, params).records;
    EXPECT_LE(records, average + 1e-9);
    EXPECT_GT(records, 0.98 * average);
  }
}

TEST(PlanRecordCost, KeepsATargetErrorOfASmallViewExactly) {
  const HairView hair(72, 56);
  for (const ReductionMethod method :
       {ReductionMethod::strong_kmeans, ReductionMethod::light_fit_fast}) {
    double more = std::numeric_limits<double>::infinity();
    for (const float target : {0.04f, 0.1f, 0.3f}) {
      ReductionParams params = hair.params(method, 9);
      params.record_cost = hair.plan(params, {.target_error = target});
      ASSERT_GT(params.record_cost, 0);
      const Outcome outcome = reduce_view(hair, params);
      EXPECT_LE(outcome.error, 1.000001 * target * outcome.value);
      EXPECT_GT(outcome.error, 0.98 * target * outcome.value);
      EXPECT_LT(outcome.records, more);
      more = outcome.records;
    }
  }
}

TEST(PlanRecordCost, IsCloseFromAPartOfALargerView) {
  const HairView hair(184, 168);
  ReductionParams params = hair.params(ReductionMethod::kmeans, 9);
  params.record_cost = hair.plan(params, {.average_records = 2});
  EXPECT_NEAR(reduce_view(hair, params).records, 2, 0.04);
  params.record_cost = hair.plan(params, {.target_error = 0.1f});
  const Outcome outcome = reduce_view(hair, params);
  EXPECT_NEAR(outcome.error, 0.1 * outcome.value, 0.005 * outcome.value);
}

TEST(PlanRecordCost, AnEmptyViewCostsNextToNothing) {
  HairView hair(32, 32);
  hair.scene.camera.target = hair.scene.camera.eye * 2.0f - hair.scene.camera.target;
  hair.view = make_view_sampler(hair.scene, hair.tracer, 32, 32, 9, 2);
  const float cost =
      hair.plan(hair.params(ReductionMethod::strong_kmeans, 8), {.average_records = 2});
  EXPECT_GT(cost, 0) << "0 would mean no budget";
  EXPECT_LT(cost, 1e-30f);
}

TEST(PrepareBudget, IsStoredWithPredictedErrors) {
  const HairView hair(48, 40);
  PrepareParams params;
  params.spp = 9;
  params.width = 48;
  params.height = 40;
  params.reduction.method = ReductionMethod::strong_kmeans;
  params.reduction.records = 9;
  params.budget.average_records = 1;
  const RelightCache cache = prepare_in_memory(hair.scene, hair.tracer, params, {});
  EXPECT_EQ(cache.info().average_records, 1);
  EXPECT_EQ(cache.info().target_error, 0);
  ASSERT_EQ(cache.predicted_error().size(), 48u * 40);
  double covered = 0;
  double without = 0;
  for (size_t i = 0; i < cache.coverage().size(); ++i) {
    const bool is_covered = cache.coverage()[i] > 0;
    covered += is_covered;
    without += is_covered && cache.record_counts()[i] == 0;
    if (!is_covered) {
      EXPECT_EQ(cache.record_counts()[i], 0);
      EXPECT_EQ(cache.predicted_error()[i], 0);
    }
  }
  EXPECT_GT(without, 0) << "pixels too dark for a record keep their coverage";
  EXPECT_LT(without, 0.7 * covered);
  EXPECT_LE(static_cast<double>(cache.info().record_count), covered);
  EXPECT_GT(static_cast<double>(cache.info().record_count), 0.98 * covered);
}

TEST(MethodLights, AreWhatTheMethodNeeds) {
  const HairView hair(16, 16);
  const auto make = [&](ReductionMethod method, bool predict_error) {
    ReductionParams params = hair.params(method, 8);
    params.predict_error = predict_error;
    return make_method_lights(hair.scene, hair.view, params, {.lights = 7, .seed = 2});
  };
  EXPECT_EQ(make(ReductionMethod::kmeans, false)->lights().training, nullptr);
  EXPECT_EQ(make(ReductionMethod::kmeans, false)->lights().validation, nullptr);
  EXPECT_EQ(make(ReductionMethod::kmeans, true)->lights().training, nullptr);
  EXPECT_EQ(make(ReductionMethod::kmeans, true)->lights().validation->lights->light_count, 40);
  EXPECT_EQ(make(ReductionMethod::light_metric_4, false)->lights().training->lights->light_count,
            7);
  const auto fit = make(ReductionMethod::light_fit, false);
  ASSERT_NE(fit->lights().validation, nullptr);
  EXPECT_EQ(fit->lights().training->lights->light_count, 128);
  EXPECT_EQ(fit->lights().validation->lights->light_count, 40);
  for (const Light& light : fit->validation->lights->lights) {
    for (const Light& other : fit->training->lights->lights) {
      if (light.type != other.type) continue;
      const bool same = light.type == LightType::directional ? light.direction == other.direction
                                                             : light.position == other.position;
      ASSERT_FALSE(same) << "fitted and judged by the same light";
    }
  }
}

}  // namespace
}  // namespace relume

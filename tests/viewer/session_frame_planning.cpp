// Records and formats chosen for a time or an error.

#include <gtest/gtest.h>

#include "core/samples/relight_cache.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/session/frame_planning.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

/// Pixels of value 1 whose error is 1 / (1 + records).
FrameForecast make_forecast() {
  FrameForecast forecast;
  forecast.formats = {{CacheFormat::exact, 0, 1, 4},
                      {CacheFormat::standard, 0.001, 1, 2},
                      {CacheFormat::compact, 0.2, 1, 1}};
  for (int i = 0; i < 10; ++i) {
    ErrorCurve& curve = forecast.curves.emplace_back();
    curve.value = 1;
    for (const int records : record_steps) {
      if (records > 16) break;
      curve.errors.push_back(1.0f / (1.0f + static_cast<float>(records)));
      curve.records.push_back(records);
    }
  }
  return forecast;
}

TEST(FramePlanning, ATimeTakesTheFormatWithLeastError) {
  // Some 12 ms are planned with: 3 exact records (0.25), 5 standard ones (1 / 6) or 8 compact ones,
  // which lose 0.2 by themselves.
  const FramePlan plan = choose_plan(make_forecast(), {.frame_ms = 13});
  EXPECT_EQ(plan.format, CacheFormat::standard);
  EXPECT_NEAR(plan.average_records, 5, 0.5);
  EXPECT_NEAR(plan.error, 1.0 / 6, 0.02);
  EXPECT_LE(plan.move_ms, 13);
  EXPECT_TRUE(plan.is_met);
}

TEST(FramePlanning, MoreTimeIsNeverWorse) {
  double last = 1;
  for (float ms = 3; ms < 60; ms *= 1.3f) {
    const FramePlan plan = choose_plan(make_forecast(), {.frame_ms = ms});
    EXPECT_TRUE(plan.is_met) << ms;
    EXPECT_LE(plan.move_ms, ms);
    EXPECT_LE(plan.error, last + 1e-6) << ms;
    last = plan.error;
  }
  EXPECT_NEAR(last, 1.0 / 9, 1e-6);  // most_planned_records, in the exact format
}

TEST(FramePlanning, TooLittleTimeTakesTheFastestAndSaysSo) {
  const FramePlan plan = choose_plan(make_forecast(), {.frame_ms = 0.5f});
  EXPECT_EQ(plan.format, CacheFormat::compact);
  EXPECT_FALSE(plan.is_met);
}

TEST(FramePlanning, AGivenFormatStays) {
  FrameGoal goal{.frame_ms = 12, .format = CacheFormat::compact};
  EXPECT_EQ(choose_plan(make_forecast(), goal).format, CacheFormat::compact);
  goal = {.target_error = 0.3f, .format = CacheFormat::exact};
  EXPECT_EQ(choose_plan(make_forecast(), goal).format, CacheFormat::exact);
}

TEST(FramePlanning, AnErrorTakesTheSmallestFormatThatLosesLittle) {
  FramePlan plan = choose_plan(make_forecast(), {.target_error = 0.15f});
  EXPECT_EQ(plan.format, CacheFormat::standard);
  EXPECT_LE(plan.error, 0.15);
  EXPECT_TRUE(plan.is_met);
  plan = choose_plan(make_forecast(), {.target_error = 0.7f});
  EXPECT_EQ(plan.format, CacheFormat::compact);
  EXPECT_LE(plan.error, 0.7);
  // Not even the most records of the curves reach this.
  EXPECT_FALSE(choose_plan(make_forecast(), {.target_error = 0.01f}).is_met);
}

class PreparedForAGoal : public testing::Test {
 protected:
  PrepareStats prepare(PrepareParams params) {
    params.width = 96;
    params.height = 80;
    params.reduction.records = 16;
    PrepareStats stats;
    cache_ = prepare_in_memory(scene_, tracer_, params, {}, &stats);
    return stats;
  }
  Scene scene_ = load_scene("hair", shader_table());
  Tracer tracer_{scene_};
  std::optional<RelightCache> cache_;
};

TEST_F(PreparedForAGoal, ATargetErrorGetsAFormatAndIsRepeatable) {
  PrepareParams params;
  params.budget.target_error = 0.05f;
  const PrepareStats stats = prepare(params);
  ASSERT_TRUE(stats.plan);
  EXPECT_TRUE(stats.plan->is_met);
  EXPECT_EQ(cache_->info().format, stats.plan->format);
  EXPECT_NE(stats.plan->format, CacheFormat::exact);
  EXPECT_LE(stats.plan->error, 0.05);
  EXPECT_EQ(cache_->info().target_error, 0.05f);
  const uint64_t records = cache_->info().record_count;
  EXPECT_EQ(prepare(params).records, records);
  // A format that is given needs no forecast.
  params.format = CacheFormat::exact;
  EXPECT_FALSE(prepare(params).plan);
  EXPECT_EQ(cache_->info().format, CacheFormat::exact);
}

TEST_F(PreparedForAGoal, MoreTimeGetsMoreRecords) {
  PrepareParams params;
  params.frame_ms = 1e-3f;
  const PrepareStats little = prepare(params);
  ASSERT_TRUE(little.plan);
  EXPECT_FALSE(little.plan->is_met);
  params.frame_ms = 1e4f;
  const PrepareStats much = prepare(params);
  EXPECT_TRUE(much.plan->is_met);
  EXPECT_GT(much.records, 4 * little.records);
  EXPECT_LT(much.plan->error, little.plan->error);
  EXPECT_GT(cache_->info().average_records, 6);
}

}  // namespace
}  // namespace relume

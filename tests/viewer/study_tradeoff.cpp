#include <gtest/gtest.h>

#include <limits>

#include "core/base/parallel.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/study/tradeoff_study.h"

namespace relume {
namespace {

TradeoffFigure make_figure(double error, double ms, int traced = 0) {
  TradeoffFigure figure;
  figure.error = error;
  figure.ms_light = ms;
  figure.traced_spp = traced;
  return figure;
}

TEST(Tradeoff, FrontHoldsWhatNothingBeats) {
  std::vector<TradeoffFigure> figures{make_figure(1, 10), make_figure(2, 5),    make_figure(2, 6),
                                      make_figure(3, 5),  make_figure(0.5, 90), make_figure(1, 10)};
  mark_pareto(figures);
  const bool expected[] = {true, true, false, false, true, true};
  for (size_t i = 0; i < figures.size(); ++i) EXPECT_EQ(figures[i].is_pareto, expected[i]) << i;
}

TEST(Tradeoff, RecommendsTheLeastErrorWithinTheTime) {
  const std::vector<TradeoffFigure> figures{make_figure(3, 8), make_figure(2, 25),
                                            make_figure(2, 20), make_figure(1, 70),
                                            make_figure(0.1, 15, 4)};
  EXPECT_EQ(recommend(figures, 30), &figures[2]) << "the faster of equals, never one traced anew";
  EXPECT_EQ(recommend(figures, std::numeric_limits<double>::infinity()), &figures[3]);
  EXPECT_EQ(recommend(figures, 5), &figures[0]) << "none fits: the fastest";
  EXPECT_EQ(recommend({}, 30), nullptr);
}

TradeoffParams make_small_params() {
  TradeoffParams params;
  params.trials = {{ReductionMethod::all, 9, {}, CacheFormat::exact, ShadowMethod::ray},
                   {ReductionMethod::all, 9, {}, CacheFormat::exact, ShadowMethod::none},
                   {ReductionMethod::pure, 1, {}, CacheFormat::exact, ShadowMethod::ray}};
  params.traced_spp = {1, 16};
  params.spp = 9;
  params.truth_spp = 64;
  params.lights = 2;
  params.repeats = 1;
  params.width = 48;
  params.height = 48;
  return params;
}

TEST(Tradeoff, ErrorsFallWithSamplesAndShadowsAreNeeded) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Tracer tracer(scene);
  TrialLog log;
  const auto figures = study_tradeoff(scene, tracer, make_small_params(), log, {}).figures;
  ASSERT_EQ(figures.size(), 5u);
  EXPECT_LT(2 * figures[0].error, figures[1].error) << "spheres throw shadows";
  EXPECT_LT(figures[0].error, figures[2].error) << "nine samples against one";
  EXPECT_LT(figures[4].error, figures[3].error) << "16 samples against one";
  EXPECT_LT(figures[4].error, 0.1 * figures[4].reference_mean);
  for (const TradeoffFigure& figure : figures) EXPECT_GT(figure.ms_light, 0);
}

TEST(Tradeoff, ErrorsDoNotDependOnThreadsAndAreTakenFromTheLog) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Tracer tracer(scene);
  TrialLog log;
  set_thread_count(1);
  const auto one = study_tradeoff(scene, tracer, make_small_params(), log, {}).figures;
  set_thread_count(0);
  TrialLog other;
  const auto all = study_tradeoff(scene, tracer, make_small_params(), other, {}).figures;
  const auto again = study_tradeoff(scene, tracer, make_small_params(), log, {}).figures;
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].error, all[i].error) << i;
    EXPECT_EQ(one[i].error, again[i].error) << i;
    EXPECT_EQ(one[i].ms_light, again[i].ms_light) << i;
  }
}

}  // namespace
}  // namespace relume

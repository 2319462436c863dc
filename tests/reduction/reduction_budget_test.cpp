// Records shared out over pixels, against trying all ways to share them out.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/base/random.h"
#include "reduction/budget.h"

namespace relume {
namespace {

ErrorCurve make_curve(std::vector<float> errors, float value = 1) {
  ErrorCurve curve;
  for (size_t i = 0; i < errors.size(); ++i) curve.records.push_back(record_steps[i]);
  curve.errors = std::move(errors);
  curve.value = value;
  return curve;
}

/// Falling errors, convex or not; now and then a step that does not help or that came out with
/// fewer records.
std::vector<ErrorCurve> random_curves(int count, int steps, uint64_t seed) {
  Random random(seed, RandomStream::tests, 0);
  std::vector<ErrorCurve> curves;
  for (int i = 0; i < count; ++i) {
    std::vector<float> errors{std::pow(10.0f, random.uniform(-3, 1))};
    while (static_cast<int>(errors.size()) < steps) {
      const float choice = random.uniform();
      const float factor = choice < 0.1f   ? 1.1f
                           : choice < 0.2f ? 1.0f
                                           : random.uniform(0.05f, 0.9f);
      errors.push_back(errors.back() * factor);
    }
    if (random.uniform() < 0.3f) errors.back() = 0;
    curves.push_back(make_curve(std::move(errors), random.uniform(0.1f, 1)));
    if (steps > 2 && random.uniform() < 0.2f) --curves.back().records.back();
  }
  return curves;
}

struct Totals {
  int records = 0;
  double error = 0;
};

Totals totals_at(const std::vector<ErrorCurve>& curves, float cost) {
  Totals totals;
  for (const ErrorCurve& curve : curves) {
    const size_t step = choose_step(curve, cost);
    totals.records += curve.records[step];
    totals.error += double{curve.errors[step]};
  }
  return totals;
}

/// The least error of any allocation, for every number of records in all.
std::map<int, double> least_errors(const std::vector<ErrorCurve>& curves) {
  std::map<int, double> least{{0, 0.0}};
  for (const ErrorCurve& curve : curves) {
    std::map<int, double> next;
    for (const auto& [records, error] : least) {
      for (size_t i = 0; i < curve.errors.size(); ++i) {
        const double sum = error + double{curve.errors[i]};
        const auto [at, is_new] = next.insert({records + curve.records[i], sum});
        if (!is_new) at->second = std::min(at->second, sum);
      }
    }
    least = std::move(next);
  }
  return least;
}

/// The lower convex hull of `least` at `records`, which may lie between whole numbers.
double hull_at(const std::map<int, double>& least, double records) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& [r0, e0] : least) {
    for (const auto& [r1, e1] : least) {
      if (r0 > records || r1 < records) continue;
      const double t = r1 > r0 ? (records - r0) / (r1 - r0) : 0;
      lowest = std::min(lowest, e0 + t * (e1 - e0));
    }
  }
  return lowest;
}

double value_of_all(const std::vector<ErrorCurve>& curves) {
  double value = 0;
  for (const ErrorCurve& curve : curves) value += double{curve.value};
  return value;
}

TEST(ChooseStep, TakesTheLeastTotal) {
  const ErrorCurve curve = make_curve({10, 6, 3, 2, 1.5f});
  EXPECT_EQ(choose_step(curve, 0), 4u);
  EXPECT_EQ(choose_step(curve, 0.75f), 3u);
  EXPECT_EQ(choose_step(curve, 2), 2u);
  EXPECT_EQ(choose_step(curve, 3.9f), 1u);
  EXPECT_EQ(choose_step(curve, 100), 0u);
}

TEST(ChooseStep, TiesGoToFewerRecords) {
  const ErrorCurve curve = make_curve({4, 3, 2, 1, 1});
  EXPECT_EQ(choose_step(curve, 1), 0u);
  EXPECT_EQ(choose_step(curve, 0), 3u);
  EXPECT_EQ(choose_step(make_curve({0, 0, 0}), 0), 0u);
}

TEST(ChooseStep, FindsTheBestOfCurvesThatAreNotConvex) {
  EXPECT_EQ(choose_step(make_curve({10, 10, 10, 1}), 2), 3u);
  EXPECT_EQ(choose_step(make_curve({1, 2, 3, 0.5f}), 0.1f), 3u);
  EXPECT_EQ(choose_step(make_curve({1, 2, 3, 0.5f}), 0.2f), 0u);
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const ErrorCurve curve = random_curves(1, 9, seed)[0];
    for (const float cost : {0.0f, 1e-4f, 1e-2f, 1.0f}) {
      const auto total = [&](size_t i) {
        return curve.errors[i] + double{cost} * curve.records[i];
      };
      const size_t chosen = choose_step(curve, cost);
      for (size_t i = 0; i < curve.errors.size(); ++i) {
        if (i < chosen) {
          ASSERT_GT(total(i), total(chosen)) << "seed " << seed << " step " << i;
        }
        if (i > chosen) {
          ASSERT_GE(total(i), total(chosen)) << "seed " << seed << " step " << i;
        }
      }
    }
  }
}

TEST(ChooseStep, RefusesCurvesWithoutEntries) {
  EXPECT_DEATH(choose_step(ErrorCurve{}, 1), "errors");
  ErrorCurve curve = make_curve({1, 0});
  curve.records.pop_back();
  EXPECT_DEATH(choose_step(curve, 1), "errors");
}

TEST(RecordBudget, KeepsAnAverageAndIsOnTheHull) {
  for (uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<ErrorCurve> curves = random_curves(5, 6, seed);
    const std::map<int, double> least = least_errors(curves);
    const double scale = least.at(0);
    for (const float average : {0.3f, 1.0f, 1.7f, 2.5f, 4.0f}) {
      SCOPED_TRACE(testing::Message() << "average " << average);
      const float cost = solve_record_cost(curves, {.average_records = average});
      const Totals totals = totals_at(curves, cost);
      const double budget = 5.0 * average;
      ASSERT_LE(totals.records, budget + 1e-6);
      // No allocation of as many records or fewer has less error.
      for (const auto& [records, error] : least) {
        if (records <= totals.records) {
          ASSERT_GE(error, totals.error - 1e-9 * scale);
        }
      }
      if (cost == 0) continue;
      // The next cheaper record does not fit, and between the two lies the hull of all allocations.
      ASSERT_GT(totals_at(curves, cost * (1 - 1e-5f)).records, budget);
      ASSERT_NEAR(totals.error - double{cost} * (budget - totals.records), hull_at(least, budget),
                  1e-4 * scale);
    }
  }
}

TEST(RecordBudget, KeepsATargetErrorWithFewestRecords) {
  for (uint64_t seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const std::vector<ErrorCurve> curves = random_curves(5, 6, seed);
    const std::map<int, double> least = least_errors(curves);
    const double value = value_of_all(curves);
    const double reachable = totals_at(curves, 0).error;
    for (const float target : {0.01f, 0.05f, 0.2f, 0.8f}) {
      SCOPED_TRACE(testing::Message() << "target " << target);
      const float cost = solve_record_cost(curves, {.target_error = target});
      const Totals totals = totals_at(curves, cost);
      if (reachable > double{target} * value) {
        ASSERT_EQ(cost, 0) << "as exact as can be";
        continue;
      }
      ASSERT_LE(totals.error, double{target} * value);
      for (const auto& [records, error] : least) {
        if (error <= totals.error) {
          ASSERT_GE(records, totals.records);
        }
      }
      // The next dearer record is too dear, unless there is none at all.
      if (totals.records > 0) {
        ASSERT_GT(totals_at(curves, cost * (1 + 1e-5f)).error, double{target} * value);
      }
    }
  }
}

TEST(RecordBudget, LargerBudgetsAreCheaperAndLargerErrorsDearer) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const std::vector<ErrorCurve> curves = random_curves(40, 10, seed);
    float previous = std::numeric_limits<float>::infinity();
    for (float average = 0.1f; average < 12; average *= 1.3f) {
      const float cost = solve_record_cost(curves, {.average_records = average});
      ASSERT_LE(cost, previous) << "seed " << seed << " average " << average;
      previous = cost;
    }
    ASSERT_EQ(previous, 0) << "more than the largest step";
    for (float target = 1e-4f; target < 1; target *= 1.5f) {
      const float cost = solve_record_cost(curves, {.target_error = target});
      ASSERT_GE(cost, previous) << "seed " << seed << " target " << target;
      previous = cost;
    }
    ASSERT_GT(previous, 0);
  }
}

TEST(RecordBudget, CostsNothingWhenAllFits) {
  const std::vector<ErrorCurve> curves = {make_curve({4, 2, 1, 0.5f}), make_curve({1, 0})};
  EXPECT_EQ(solve_record_cost(curves, {.average_records = 2}), 0) << "3 + 1 records of 4";
  EXPECT_GT(solve_record_cost(curves, {.average_records = 1.9f}), 0);
  EXPECT_EQ(solve_record_cost(curves, {.target_error = 0.2f}), 0) << "0.5 of 2 is out of reach";
  EXPECT_GT(solve_record_cost(curves, {.target_error = 0.3f}), 0);
}

TEST(RecordBudget, DegenerateCurves) {
  const std::vector<std::vector<ErrorCurve>> cases = {
      {},
      {make_curve({0})},
      {make_curve({0}), make_curve({0, 0, 0})},
      {make_curve({0, 0, 0}, 0), make_curve({0, 0}, 0)},
  };
  for (const std::vector<ErrorCurve>& curves : cases) {
    EXPECT_EQ(solve_record_cost(curves, {.average_records = 0.5f}), 0);
    EXPECT_EQ(solve_record_cost(curves, {.target_error = 0.1f}), 0);
  }
  // Pixels that more records do not help get none as soon as a record costs anything.
  const std::vector<ErrorCurve> flat(10, make_curve({1, 1, 1}));
  EXPECT_EQ(totals_at(flat, solve_record_cost(flat, {.average_records = 1})).records, 0);
}

TEST(RecordBudget, EqualPixelsStayBelowTheirAverage) {
  // 2.5 records each cannot be shared out by one cost: all take 2.
  const std::vector<ErrorCurve> curves(100, make_curve({8, 4, 2, 1, 0.5f}));
  const float cost = solve_record_cost(curves, {.average_records = 2.5f});
  EXPECT_EQ(totals_at(curves, cost).records, 200);
  EXPECT_NEAR(cost, 1, 1e-5) << "the third saves 1";
}

TEST(RecordBudget, ExposureDoesNotMatter) {
  const std::vector<ErrorCurve> curves = random_curves(30, 10, 7);
  for (const float scale : {0x1p-100f, 0x1p-60f, 0x1p60f, 0x1p120f}) {
    std::vector<ErrorCurve> scaled = curves;
    for (ErrorCurve& curve : scaled) {
      curve.value *= scale;
      for (float& error : curve.errors) error *= scale;
    }
    for (const RecordBudget& budget :
         {RecordBudget{.average_records = 2}, RecordBudget{.target_error = 0.1f}}) {
      const float cost = solve_record_cost(curves, budget);
      ASSERT_GT(cost, 0);
      EXPECT_FLOAT_EQ(solve_record_cost(scaled, budget) / scale, cost) << "scale " << scale;
    }
  }
}

TEST(RecordBudget, LargestErrorsGiveAFiniteCost) {
  constexpr float largest = std::numeric_limits<float>::max();
  std::vector<ErrorCurve> curves(9, make_curve({1, 0.5f, 0.25f}));
  curves.push_back(make_curve({largest, largest, 1}));
  const float cost = solve_record_cost(curves, {.average_records = 1});
  EXPECT_TRUE(std::isfinite(cost));
  const Totals totals = totals_at(curves, cost);
  EXPECT_LE(totals.records, 10);
  EXPECT_LT(totals.error, 20) << "the worst pixel is served first";
}

}  // namespace
}  // namespace relume

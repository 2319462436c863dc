#include "reduction/budget.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace relume {
namespace {

struct Totals {
  double records = 0;
  double error = 0;
};

Totals totals_at(std::span<const ErrorCurve> curves, float cost) {
  Totals totals;
  for (const ErrorCurve& curve : curves) {
    const size_t step = choose_step(curve, cost);
    totals.records += curve.records[step];
    totals.error += curve.errors[step];
  }
  return totals;
}

}  // namespace

size_t choose_step(const ErrorCurve& curve, float cost) {
  CHECK(!curve.errors.empty() && curve.errors.size() == curve.records.size());
  size_t best = 0;
  double least = 0;
  for (size_t i = 0; i < curve.errors.size(); ++i) {
    const double total = curve.errors[i] + double{cost} * curve.records[i];
    if (i > 0 && !(total < least)) continue;
    least = total;
    best = i;
  }
  return best;
}

BudgetOutcome outcome_at(std::span<const ErrorCurve> curves, float cost) {
  double value = 0;
  for (const ErrorCurve& curve : curves) value += curve.value;
  const Totals totals = totals_at(curves, cost);
  return {curves.empty() ? 0 : totals.records / static_cast<double>(curves.size()),
          value > 0 ? totals.error / value : 0};
}

float solve_record_cost(std::span<const ErrorCurve> curves, const RecordBudget& budget) {
  if (curves.empty()) return 0;
  float most = 0;
  double value = 0;
  for (const ErrorCurve& curve : curves) {
    most = std::max(most, curve.errors.front());
    value += curve.value;
  }
  const auto fits = [&](float cost) {
    const Totals totals = totals_at(curves, cost);
    // More cost, fewer records, more error: an average wants the least cost that keeps to it, an
    // error the largest.
    return budget.average_records > 0 ? totals.records <= double{budget.average_records} *
                                                              static_cast<double>(curves.size())
                                      : totals.error > double{budget.target_error} * value;
  };
  if (!(most > 0) || fits(0)) return 0;
  float low = 0;  // does not fit
  // No record is worth this much.
  float high = std::min(2 * most, std::numeric_limits<float>::max());
  // Errors span many magnitudes: halve the interval's ratio once it has one.
  for (int i = 0; i < 60; ++i) {
    const float middle = low > 0 ? static_cast<float>(std::sqrt(double{low} * high)) : 1e-3f * high;
    if (!(middle > low && middle < high)) break;
    (fits(middle) ? high : low) = middle;
  }
  return budget.average_records > 0 ? high : low;
}

}  // namespace relume

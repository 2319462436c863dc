#pragma once

#include "core/base/progress.h"
#include "core/samples/sample_scene.h"
#include "reduction/budget.h"
#include "reduction/reduction.h"
#include "reduction/training.h"

namespace relume {

/// Records of a view under a budget.
struct RecordPlan {
  float record_cost = 0;  ///< > 0, see solve_record_cost
  /// Of pixels drawn evenly from those with samples; exact for any cost from record_cost up.
  std::vector<ErrorCurve> curves;
  double covered_part = 0;  ///< of the view's pixels, estimated from those that were drawn
};

/// The record_cost that meets `budget` over the whole view, from the error curves of up to
/// 16,384 pixels drawn evenly from the picture. The average that comes out differs from the one
/// asked for by about the standard error of that sample, and planning costs the same at any
/// resolution. Deterministic in reduction.seed, for any thread count.
RecordPlan plan_records(const Scene& scene, const ViewSampler& view,
                        const ReductionParams& reduction, const TrainingParams& training,
                        const RecordBudget& budget, const ProgressCallback& progress);

}  // namespace relume

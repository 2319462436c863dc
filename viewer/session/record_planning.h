#pragma once

#include "core/base/progress.h"
#include "core/samples/sample_scene.h"
#include "reduction/budget.h"
#include "reduction/reduction.h"
#include "reduction/training.h"

namespace relume {

/// The record_cost that meets `budget` over the whole view, from the error curves of about
/// `planning_pixels` covered pixels spread over all tiles: each tile gives as many, at random. So
/// the average that comes out differs from the one asked for by about the standard error of that
/// sample, and planning costs the same for any resolution. Deterministic in reduction.seed.
float plan_record_cost(const Scene& scene, const ViewSampler& view,
                       const ReductionParams& reduction, const TrainingParams& training,
                       const RecordBudget& budget, const ProgressCallback& progress);

}  // namespace relume

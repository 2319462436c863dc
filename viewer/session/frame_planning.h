#pragma once

#include <array>

#include "core/base/progress.h"
#include "core/samples/sample_scene.h"
#include "reduction/budget.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "shadow/shadow.h"

namespace relume {

/// How quick or how exact frames shall be. At most one of the two is above 0.
struct FrameGoal {
  float frame_ms = 0;      ///< that moving one light takes, at most, on this machine
  float target_error = 0;  ///< as in RecordBudget, what the format loses included
  /// What a move pays for beside shading. Not `auto`s and the like: they keep a time themselves.
  ShadowMethod shadows = ShadowMethod::none;
  std::optional<CacheFormat> format = {};  ///< the only one to choose; nothing: any

  bool is_set() const { return frame_ms > 0 || target_error > 0; }
};

/// The records and the format that reach a goal.
struct FramePlan {
  CacheFormat format = CacheFormat::exact;
  float record_cost = 0;       ///< see ReductionParams
  double average_records = 0;  ///< predicted, per covered pixel
  double error = 0;            ///< predicted, of records and format together, as RecordBudget's
  double move_ms = 0;          ///< predicted; 0 where the goal is an error
  bool is_met = false;
};

/// Average records that are planned at most, however slow frames may be: more hardly help.
inline constexpr float most_planned_records = 8;

/// What is known about a view before it is prepared.
struct FrameForecast {
  struct Format {
    CacheFormat format;
    double error = 0;          ///< that it adds, a fraction of the picture's mean
    double fixed_ms = 0;       ///< of a move
    double ms_per_record = 0;  ///< of a move, per average record
  };
  std::vector<Format> formats;     ///< largest first
  std::vector<ErrorCurve> curves;  ///< of the pixels, see RecordPlan
  float least_cost = 0;            ///< from which on they are exact
};

/// The best plan: under a time the format and records with the least error, under an error the
/// smallest format that loses no more than a third of it. Errors of records and of the format are
/// independent: their squares add.
FramePlan choose_plan(const FrameForecast& forecast, const FrameGoal& goal);

/// Forecasts from a part of the view: every eighth tile is prepared with few and with more records,
/// in each format, and, for a time, a light is moved over it. Times are the machine's, so that a
/// plan for a time is not repeatable; one for an error is.
FrameForecast forecast_frames(const Scene& scene, const ViewSampler& view,
                              const ReductionParams& reduction, const TrainingParams& training,
                              const FrameGoal& goal, const ProgressCallback& progress);

/// Least wall time, milliseconds, of moving one light over `cache`, which caches of the processor
/// do not hold.
double measure_move_ms(const RelightCache& cache, VisibilitySource* shadows);

}  // namespace relume

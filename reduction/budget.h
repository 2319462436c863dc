#pragma once

#include <array>
#include <span>
#include <vector>

namespace relume {

/// How many records a whole picture may have, or how exact it must be: then every pixel gets its
/// own k. At most one of the two is set; neither means a fixed k.
struct RecordBudget {
  float average_records = 0;  ///< per covered pixel, (0, 64]
  /// Mean predicted error over covered pixels (PixelReducer), as a fraction of their mean value
  /// under the same lights, (0, 1).
  float target_error = 0;

  bool is_set() const { return average_records > 0 || target_error > 0; }
};

/// The k that a pixel under a budget chooses from, up to its limit; more is rarely worth its cost
/// between the last ones.
inline constexpr std::array record_steps = {0,  1,  2,  3,  4,  5,  6,  7,  8, 10,
                                            12, 14, 16, 20, 24, 32, 40, 48, 64};

/// One pixel's predicted error for every k of record_steps that was tried.
struct ErrorCurve {
  std::vector<float>
      errors;  ///< errors[i] belongs to record_steps[i]; errors[0] is the pixel itself
  std::vector<int> records;  ///< records that came out, <= record_steps[i]
  float value = 0;           ///< the pixel's mean value under the same lights
};

/// The index of the curve's entry with least error + cost * records; ties to fewer records.
size_t choose_step(const ErrorCurve& curve, float cost);

/// What pixels that each minimise error + cost * records come to.
struct BudgetOutcome {
  double average_records = 0;
  double error = 0;  ///< mean over the pixels, as a fraction of their mean value
};
BudgetOutcome outcome_at(std::span<const ErrorCurve> curves, float cost);

/// The error that a record must save to be worth its place, so that pixels that each minimise
/// error + cost * records (choose_step) meet the budget together: Everett's Lagrangian allocation
/// (1963), optimal over the convex hull of the curves. The curves are a fair sample of the
/// picture's covered pixels. An average stays at or below the budget, an error too. 0 when even all
/// records of all curves are within an average, or no cost reaches the target.
float solve_record_cost(std::span<const ErrorCurve> curves, const RecordBudget& budget);

}  // namespace relume

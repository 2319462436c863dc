#pragma once

#include <array>

#include "core/base/label.h"
#include "core/samples/record_layout.h"
#include "viewer/session/view_state.h"

namespace relume {

struct FrameForecast;

/// The records that a plan for `trade` takes, and what comes of them.
struct TradePlan {
  RecordChoice records;
  float record_cost = 0;  ///< see ReductionParams
  double move_ms = 0;     ///< predicted, of moving one light, without shadows
  double error = 0;       ///< predicted, a fraction of the picture's mean, without shadows
  bool is_met = true;     ///< false: the time or the error asked for is out of reach
};

/// Chooses records and format for a trade that is not manual. A level takes 1 record a pixel on
/// average at 0 and 8 at 1, evenly in their logarithm, in the quickest format that hardly adds to
/// the error. A time leaves half of it to shadows, where `has_shadows`. Averages have two digits,
/// so that they can be asked for again (PrepareOptions::budget).
TradePlan plan_trade(const Trade& trade, const FrameForecast& forecast, bool has_shadows);

/// What a trade says about frames whatever their records: shadows as exact as the time allows where
/// there are shadows, when frames are coarse, and whether all samples follow at rest.
void apply_trade(ViewState& view);

/// From here on a level means exact: every sample, traced, when the lights rest.
inline constexpr float exact_level = 0.98f;

}  // namespace relume

#include "viewer/session/trade.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "viewer/session/frame_planning.h"

namespace relume {
namespace {

/// Of the time of a move, where shadows need some of it, too.
constexpr float shading_part = 0.5f;
/// A format may add so much to the least error.
constexpr double hardly_more = 1.05;
constexpr float fastest_frame_ms = 10;
constexpr float exact_frame_ms = 200;

/// `value` > 0 with two digits, not above it (or not below).
double two_digits(double value, bool up) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 1);
  const double steps = value / step;
  constexpr double slack = 1e-6;
  return step * (up ? std::ceil(steps - slack) : std::floor(steps + slack));
}

TradePlan plan_average(const FrameForecast& forecast, const FrameForecast::Format& format,
                       double average_records) {
  TradePlan plan;
  plan.records = {static_cast<float>(average_records), format.format};
  plan.record_cost =
      std::max(solve_record_cost(forecast.curves, {.average_records = plan.records.average}),
               forecast.least_cost);
  const BudgetOutcome outcome = outcome_at(forecast.curves, plan.record_cost);
  plan.error = std::hypot(outcome.error, format.error);
  plan.move_ms = format.fixed_ms + format.ms_per_record * outcome.average_records;
  return plan;
}

TradePlan plan_level(const FrameForecast& forecast, float level) {
  const double average = two_digits(std::pow(double{most_planned_records}, double{level}), false);
  std::vector<TradePlan> plans;
  for (const FrameForecast::Format& format : forecast.formats) {
    if (level >= exact_level && format.format != CacheFormat::exact) continue;
    plans.push_back(plan_average(forecast, format, average));
  }
  CHECK(!plans.empty());
  double least = plans.front().error;
  for (const TradePlan& plan : plans) least = std::min(least, plan.error);
  std::erase_if(plans, [&](const TradePlan& plan) { return plan.error > hardly_more * least; });
  return *std::min_element(plans.begin(), plans.end(), [](const TradePlan& a, const TradePlan& b) {
    return a.move_ms < b.move_ms;
  });
}

TradePlan plan_goal(const FrameForecast& forecast, const FrameGoal& goal) {
  const FramePlan chosen = choose_plan(forecast, goal);
  const auto format =
      std::find_if(forecast.formats.begin(), forecast.formats.end(),
                   [&](const FrameForecast::Format& row) { return row.format == chosen.format; });
  CHECK(format != forecast.formats.end());
  const double average = std::max(chosen.average_records, 0.01);
  TradePlan plan = plan_average(
      forecast, *format,
      std::min(two_digits(average, goal.target_error > 0), double{most_planned_records}));
  plan.is_met = chosen.is_met;
  return plan;
}

}  // namespace

TradePlan plan_trade(const Trade& trade, const FrameForecast& forecast, bool has_shadows) {
  switch (trade.kind) {
    case TradeKind::manual:
      break;
    case TradeKind::level:
      return plan_level(forecast, trade.level);
    case TradeKind::time:
      return plan_goal(forecast,
                       {.frame_ms = has_shadows ? shading_part * trade.move_ms : trade.move_ms});
    case TradeKind::error:
      return plan_goal(forecast, {.target_error = trade.target_error});
  }
  CHECK_MSG(false, "a manual trade plans nothing");
  return {};
}

void apply_trade(ViewState& view) {
  const Trade& trade = view.trade;
  const bool keeps_time = trade.kind == TradeKind::level || trade.kind == TradeKind::time;
  if (!keeps_time) return;
  if (view.shadows != ShadowMethod::none) view.shadows = ShadowMethod::automatic;
  if (trade.kind == TradeKind::time) {
    view.frame_ms = trade.move_ms;
    return;
  }
  view.frame_ms =
      std::round(fastest_frame_ms * std::pow(exact_frame_ms / fastest_frame_ms, trade.level));
  view.refine = trade.level >= exact_level;
}

}  // namespace relume

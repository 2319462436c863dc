#include "viewer/session/frame_budget.h"

namespace relume {
namespace {

/// Lights that are not shown yet as `after` has them.
int count_changed(const RelightRequest& after, const RelightRequest* before) {
  const bool comparable = before != nullptr && before->shadows == after.shadows;
  int changed = 0;
  for (size_t i = 0; i < after.lights.size(); ++i) {
    if (after.lights[i].mute) continue;
    const bool is_shown = comparable && i < before->lights.size() && !before->lights[i].mute &&
                          same_layer(before->lights[i], after.lights[i]);
    if (!is_shown) ++changed;
  }
  return changed;
}

}  // namespace

void FrameBudget::add(const RelitFrame& frame) {
  const double share = share_cost(frame.request.pixels);
  if (!(frame.work.records > 0) || !(share > 0)) return;
  // At rest they take their time.
  if (frame.request.shadows == ShadowMethod::automatic && !frame.request.dragging) return;
  records_ = frame.work.records / share;
  pixels_ = frame.work.pixels;
  MethodCosts& costs = costs_[static_cast<size_t>(frame.request.shadows)];
  const bool is_whole = frame.request.pixels == PixelShare::all;
  (is_whole ? costs.whole : costs.quarter).add_measurement(frame.work, frame.ms);
}

std::optional<double> FrameBudget::predict_ms(const RelightRequest& request,
                                              const RelightRequest* before) const {
  const FrameCost& cost = costs_[static_cast<size_t>(request.shadows)].of(request.pixels);
  if (cost.measurements() == 0) return {};
  const auto lights = static_cast<int>(request.lights.size());
  const int layers = request.dragging ? std::min(2, lights) : lights;
  return cost.predict_ms(
      {records_ * share_cost(request.pixels), pixels_, count_changed(request, before), layers});
}

PixelShare FrameBudget::choose_pixels(const RelightRequest& request, const RelightRequest* before,
                                      float frame_ms) const {
  if (!(frame_ms > 0)) return PixelShare::all;
  RelightRequest trial = request;
  trial.pixels = PixelShare::all;
  const auto whole_ms = predict_ms(trial, before);
  if (!whole_ms) return PixelShare::quarter;
  trial.pixels = PixelShare::quarter;
  const auto quarter_ms = predict_ms(trial, before);
  const bool pays = !quarter_ms || *quarter_ms < 2.0 / 3.0 * *whole_ms;
  return *whole_ms > static_cast<double>(frame_ms) && pays ? PixelShare::quarter : PixelShare::all;
}

}  // namespace relume

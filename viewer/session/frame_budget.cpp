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
  records_ = frame.work.records / share;
  pixels_ = frame.work.pixels;
  costs_[static_cast<size_t>(frame.request.shadows)].add_measurement(frame.work, frame.ms);
}

std::optional<double> FrameBudget::predict_ms(const RelightRequest& request,
                                              const RelightRequest* before) const {
  const FrameCost& cost = costs_[static_cast<size_t>(request.shadows)];
  if (cost.measurements() == 0) return {};
  const auto lights = static_cast<int>(request.lights.size());
  const int layers = request.dragging ? std::min(2, lights) : lights;
  return cost.predict_ms(
      {records_ * share_cost(request.pixels), pixels_, count_changed(request, before), layers});
}

PixelShare FrameBudget::choose_pixels(const RelightRequest& request, const RelightRequest* before,
                                      float frame_ms) const {
  if (!(frame_ms > 0)) return PixelShare::all;
  RelightRequest whole = request;
  whole.pixels = PixelShare::all;
  const auto ms = predict_ms(whole, before);
  return ms && *ms <= static_cast<double>(frame_ms) ? PixelShare::all : PixelShare::quarter;
}

}  // namespace relume

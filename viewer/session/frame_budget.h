#pragma once

#include <array>

#include "core/relight/frame_cost.h"
#include "viewer/session/frame_source.h"

namespace relume {

/// What shading a share of the pixels costs against all of them.
constexpr double share_cost(PixelShare pixels) {
  return pixels == PixelShare::all ? 1.0 : pixels == PixelShare::quarter ? 0.25 : 0.0;
}

/// Decides how much of a frame fits into a time, from the frames that ran: one model of cost for
/// each shadow method.
class FrameBudget {
 public:
  /// Learns from a finished frame.
  void add(const RelitFrame& frame);

  /// Milliseconds that `request` takes after `before` was shown; null = nothing was. Nothing before
  /// the first frame of its shadow method and share.
  std::optional<double> predict_ms(const RelightRequest& request,
                                   const RelightRequest* before) const;

  /// All pixels where that is predicted to take `frame_ms` or less, or where frame_ms is 0, or
  /// where a quarter of them would not save a third of the time; else a quarter. A method that
  /// never ran starts with a quarter.
  PixelShare choose_pixels(const RelightRequest& request, const RelightRequest* before,
                           float frame_ms) const;

 private:
  struct MethodCosts {
    FrameCost whole;
    FrameCost quarter;  ///< has pixels to fill in
    const FrameCost& of(PixelShare pixels) const {
      return pixels == PixelShare::all ? whole : quarter;
    }
  };

  std::array<MethodCosts, shadow_method_labels.size()> costs_;
  double records_ = 0;  ///< of the whole cache
  double pixels_ = 0;
};

}  // namespace relume

#pragma once

#include <array>

#include "core/samples/relight_cache.h"

namespace relume {

/// What one relight() has to do, in counts.
struct FrameWork {
  double records = 0;       ///< of the cache
  double pixels = 0;        ///< of the picture, without tiles that hold no records
  int changed_lights = 0;   ///< lights whose layers are shaded
  int combined_layers = 0;  ///< layers that are summed to the frame
};

/// The work of a frame from `cache`.
FrameWork make_frame_work(const RelightCache& cache, int changed_lights, int combined_layers);

/// Predicts how long relight() takes from frames that ran: a sum of rates per record, per pixel and
/// their products with lights, none of them negative, fitted to relative errors by least squares.
/// Older measurements fade where newer ones tell the same (directional forgetting: Cao and
/// Schwartz, "A directional forgetting algorithm based on the decomposition of the information
/// matrix", 2000), so that frames of one kind do not wash out what is known about others. Rates
/// differ with shaders, cache format, instruction set, threads and shadows: keep one FrameCost for
/// each of these. Not thread-safe; a call costs some microseconds.
class FrameCost {
 public:
  /// A frame of this work took `ms` milliseconds. Times that are not finite and above 0 are
  /// ignored.
  void add_measurement(const FrameWork& work, double ms);
  /// Milliseconds, >= 0. Before the first measurement an order of magnitude only.
  double predict_ms(const FrameWork& work) const;
  /// Measurements taken.
  int measurements() const { return measurements_; }

 private:
  /// Fixed, records x passes, records x lights, pixels x lights, pixels x layers, pixels.
  static constexpr int term_count = 6;
  using Terms = std::array<double, term_count>;

  static Terms terms_of(const FrameWork& work);
  void forget(const Terms& z);
  void solve();

  int measurements_ = 0;
  std::array<Terms, term_count> information_{};  ///< sum of z z', z = terms / ms
  Terms vector_{};                               ///< sum of z
  Terms rates_{1, 1, 1, 1, 1, 1};                ///< multiples of the typical rates
};

}  // namespace relume

#pragma once

#include <vector>

#include "core/relight/frame_cost.h"
#include "core/relight/relight.h"

namespace relume {

/// The cache's first light and others of its kind around it.
std::vector<Light> make_bench_lights(const CacheInfo& info, int count);

/// A picture whose unshadowed lights are changed again and again. Each call is one relight().
class RepeatedFrame {
 public:
  /// Under `lights` lights of one kind. `cache` and `shadows` must outlive this.
  RepeatedFrame(const RelightCache& cache, int lights,
                InstructionSet set = InstructionSet::automatic,
                VisibilitySource* shadows = nullptr);

  void move_all();
  /// As a person drags a light or its gain.
  void drag_one();
  void drag_gain();
  /// The same gain once, summed in order.
  void dim_one();
  /// Every light anew, into fresh memory.
  void start_again();

  /// What the last call did.
  const FrameWork& work() const { return work_; }
  int lights() const { return static_cast<int>(lights_.size()); }

 private:
  void move(Light& light) const;
  void relight_now(bool dragging = false);

  const RelightCache& cache_;
  std::vector<Light> lights_;
  RelightParams params_;
  VisibilitySource* shadows_;
  RelightState state_;
  FrameWork work_;
};

}  // namespace relume

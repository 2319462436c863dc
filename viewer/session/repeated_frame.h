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
  /// Moves one light, as one of a row of such frames: RelightParams::dragging.
  void drag_one();
  void dim_one();
  /// Dims one light, as one of a row of such frames.
  void drag_gain();
  /// Moves all for a quarter of the pixels.
  void move_all_coarsely();
  /// Every light anew, into fresh memory.
  void start_again();

  /// What the last call did.
  const FrameWork& work() const { return work_; }
  int lights() const { return static_cast<int>(lights_.size()); }

 private:
  void move(Light& light) const;
  void relight_now(const RelightParams& params, int combined_layers);

  const RelightCache& cache_;
  std::vector<Light> lights_;
  RelightParams params_;
  VisibilitySource* shadows_;
  RelightState state_;
  FrameWork work_;
};

}  // namespace relume

#include "viewer/session/repeated_frame.h"

#include <algorithm>
#include <cmath>

namespace relume {

std::vector<Light> make_bench_lights(const CacheInfo& info, int count) {
  constexpr float golden_angle = 2.39996323f;
  std::vector<Light> lights(count, info.lights.front());
  for (int i = 1; i < count; ++i) {
    const float angle = golden_angle * static_cast<float>(i);
    const vec3 side(std::cos(angle), std::sin(angle), 0.5f * std::cos(angle));
    lights[i].position += 0.2f * info.bounds.radius() * side;
    lights[i].direction += 0.1f * side;
  }
  for (Light& light : lights) light.mute = false;
  return lights;
}

RepeatedFrame::RepeatedFrame(const RelightCache& cache, int lights, InstructionSet set,
                             VisibilitySource* shadows)
    : cache_(cache),
      lights_(make_bench_lights(cache.info(), lights)),
      params_{.instruction_set = set},
      shadows_(shadows),
      state_(make_relight_state(cache)) {
  relight_now(params_, lights);
}

void RepeatedFrame::move(Light& light) const {
  light.position.x += 1e-4f * cache_.info().bounds.radius();
  light.direction.x += 1e-4f;
}

void RepeatedFrame::relight_now(const RelightParams& params, int combined_layers) {
  const RelightStats stats = relight(state_, lights_, shadows_, params);
  work_ = make_frame_work(cache_, stats.layers_shaded, combined_layers);
  if (stats.layers_shaded > 0) {
    work_.records = static_cast<double>(stats.records_shaded) / stats.layers_shaded;
  }
}

void RepeatedFrame::move_all() {
  for (Light& light : lights_) move(light);
  relight_now(params_, lights());
}

void RepeatedFrame::drag_one() {
  move(lights_[lights_.size() / 2]);
  RelightParams params = params_;
  params.dragging = true;
  relight_now(params, std::min(lights(), 2));
}

void RepeatedFrame::dim_one() {
  lights_[lights_.size() / 2].gain *= 1.001f;
  relight_now(params_, lights());
}

void RepeatedFrame::drag_gain() {
  lights_[lights_.size() / 2].gain *= 1.001f;
  RelightParams params = params_;
  params.dragging = true;
  relight_now(params, std::min(lights(), 2));
}

void RepeatedFrame::move_all_coarsely() {
  for (Light& light : lights_) move(light);
  RelightParams params = params_;
  params.pixels = PixelShare::quarter;
  relight_now(params, lights());
}

void RepeatedFrame::start_again() {
  state_.layers.clear();  // the old memory goes first
  state_ = make_relight_state(cache_);
  relight_now(params_, lights());
}

}  // namespace relume

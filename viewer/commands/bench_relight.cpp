#include "viewer/commands/bench_relight.h"

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
  relight_now();
}

void RepeatedFrame::move(Light& light) const {
  light.position.x += 1e-4f * cache_.info().bounds.radius();
  light.direction.x += 1e-4f;
}

void RepeatedFrame::relight_now(bool dragging) {
  params_.dragging = dragging;
  const RelightStats stats = relight(state_, lights_, shadows_, params_);
  const int layers = state_.others_of ? 2 : lights();
  work_ = make_frame_work(cache_, stats.layers_shaded, layers);
}

void RepeatedFrame::move_all() {
  for (Light& light : lights_) move(light);
  relight_now();
}

void RepeatedFrame::drag_one() {
  move(lights_[lights_.size() / 2]);
  relight_now(true);
}

void RepeatedFrame::drag_gain() {
  lights_[lights_.size() / 2].gain *= 1.001f;
  relight_now(true);
}

void RepeatedFrame::dim_one() {
  lights_[lights_.size() / 2].gain *= 1.001f;
  relight_now();
}

void RepeatedFrame::start_again() {
  state_.layers.clear();  // the old memory goes first
  state_ = make_relight_state(cache_);
  relight_now();
}

}  // namespace relume

#include "viewer/study/ray_memory.h"

#include <bit>

namespace relume {

void RayTargets::add(const Light& light) {
  if (!by_name_.emplace(light.name, rays_.size()).second) return;
  rays_.push_back(std::make_unique<TracedVisibility>(tracer_));
  rays_.back()->prepare(light);
}

RayMemory::RayMemory(const RayTargets& targets) : targets_(targets) {
  for (size_t light = 0; light < targets.count(); ++light) sources_.emplace_back(*this, light);
}

std::vector<const VisibilitySource*> RayMemory::sources(const LightSet& lights) const {
  std::vector<const VisibilitySource*> sources(lights.columns());
  for (size_t column = 0; column < sources.size(); ++column) {
    const Light& light = lights.lights[column];
    if (lights.padding[column] || !light.casts_shadow) continue;
    sources[column] = &sources_[targets_.find(light)];
  }
  return sources;
}

size_t RayMemory::KeyHash::operator()(const Key& key) const {
  uint64_t hash = 0;
  for (const uint32_t bits : key.bits) {
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return hash;
}

void RayMemory::find_rows(const Receivers& receivers) {
  next_keys_.clear();
  for (int i = 0; i < receivers.count; ++i) {
    Key key{};
    for (int c = 0; c < 3; ++c) {
      key.bits[c] = std::bit_cast<uint32_t>(receivers.position[c][i]);
      if (receivers.normal[c] == nullptr) continue;
      key.bits[3 + c] = std::bit_cast<uint32_t>(receivers.normal[c][i]);
    }
    key.bits[6] = std::bit_cast<uint32_t>(receivers.bias[i]);
    key.bits[7] = (receivers.lit_from_behind ? 1u : 0u) | (receivers.weight[i] > 0 ? 2u : 0u) |
                  (receivers.normal[0] != nullptr ? 4u : 0u);
    next_keys_.push_back(key);
  }
  if (next_keys_ == keys_) return;  // the same receivers, another light
  std::swap(keys_, next_keys_);
  rows_.clear();
  for (const Key& key : keys_) {
    rows_.push_back(row_of_.emplace(key, static_cast<uint32_t>(row_of_.size())).first->second);
  }
  answers_.resize(row_of_.size() * targets_.count(), Answer::unknown);
}

RayMemory::Answer RayMemory::trace(size_t light, const Receivers& receivers, int index) const {
  Receivers one = receivers;
  one.count = 1;
  one.weight += index;
  one.bias += index;
  for (int c = 0; c < 3; ++c) {
    one.position[c] += index;
    if (one.normal[c] != nullptr) one.normal[c] += index;
  }
  float visibility = 1;
  targets_.rays(light).visibility(one, &visibility);
  return visibility > 0 ? Answer::seen : Answer::hidden;
}

void RayMemory::visibility(size_t light, const Receivers& receivers, float* visibility) {
  find_rows(receivers);
  for (int i = 0; i < receivers.count; ++i) {
    Answer& answer = answers_[rows_[i] * targets_.count() + light];
    if (answer == Answer::unknown) {
      answer = trace(light, receivers, i);
      ++traced_count_;
    }
    visibility[i] = answer == Answer::seen ? 1.0f : 0.0f;
  }
}

}  // namespace relume

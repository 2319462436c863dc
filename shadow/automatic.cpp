#include "shadow/automatic.h"

#include "core/base/check.h"

namespace relume {

AutomaticVisibility::AutomaticVisibility(const ShadowContent& content, ShadowMaker make,
                                         ShadowClock now_ms)
    : chooser_(content), make_(std::move(make)), now_ms_(std::move(now_ms)) {}

void AutomaticVisibility::set_goal(ShadowLevel level, double budget_ms) {
  CHECK_MSG(budget_ms > 0, "budget {} ms", budget_ms);
  level_ = level;
  budget_ms_ = budget_ms;
}

void AutomaticVisibility::prepare_share(const Light& light, PixelShare share) {
  choice_ = chooser_.choose(level_, budget_ms_);
  std::unique_ptr<VisibilitySource>& source = made_[choice_.method];
  if (source == nullptr) source = make_(choice_.method);
  current_ = source.get();
  started_ms_ = now_ms_();
  current_->prepare_share(light, share);
}

void AutomaticVisibility::end_move() {
  if (current_ != nullptr) chooser_.add_time(choice_.method, now_ms_() - started_ms_);
}

void AutomaticVisibility::visibility(const Receivers& receivers, float* visibility) const {
  CHECK(current_ != nullptr);
  current_->visibility(receivers, visibility);
}

std::span<const float> AutomaticVisibility::all_visibility() const {
  return current_ != nullptr ? current_->all_visibility() : std::span<const float>();
}

uint64_t AutomaticVisibility::memory_bytes() const {
  uint64_t bytes = 0;
  for (const auto& [method, source] : made_) bytes += source->memory_bytes();
  return bytes;
}

}  // namespace relume

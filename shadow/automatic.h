#pragma once

#include <functional>
#include <memory>

#include "core/relight/visibility.h"
#include "shadow/shadow_choice.h"

namespace relume {

/// Makes one of the other approximators.
using ShadowMaker = std::function<std::unique_ptr<VisibilitySource>(ShadowMethod)>;

/// Milliseconds since any moment.
using ShadowClock = std::function<double()>;

/// Shadows by the method that ShadowChooser picks at each light move. Methods are made when they
/// are first picked and kept; the time for that does not count. The owner sets level and budget
/// before prepare() and says when the look-ups of a move are done; all from one thread.
class AutomaticVisibility final : public VisibilitySource {
 public:
  /// Starts at the final level.
  AutomaticVisibility(const ShadowContent& content, ShadowMaker make, ShadowClock now_ms);

  /// `budget_ms` > 0: of a move, prepare() and look-ups.
  void set_goal(ShadowLevel level, double budget_ms);

  void prepare(const Light& light) override { prepare_share(light, PixelShare::all); }
  void prepare_share(const Light& light, PixelShare share) override;
  /// The last move's look-ups are done: its time is noted. Without it a move counts for nothing.
  void end_move();

  /// Of the last prepare().
  const ShadowChoice& choice() const { return choice_; }

  void visibility(const Receivers& receivers, float* visibility) const override;
  std::span<const float> all_visibility() const override;
  /// Of all methods made so far.
  uint64_t memory_bytes() const override;

 private:
  ShadowChooser chooser_;
  ShadowMaker make_;
  ShadowClock now_ms_;
  ShadowLevel level_ = ShadowLevel::final;
  double budget_ms_ = 33;
  ShadowChoice choice_;
  std::map<ShadowMethod, std::unique_ptr<VisibilitySource>> made_;
  VisibilitySource* current_ = nullptr;
  double started_ms_ = 0;
};

}  // namespace relume

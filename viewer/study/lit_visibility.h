#pragma once

#include "core/relight/visibility.h"

namespace relume {

/// Whether `light` can light a receiver at all: it lies within a spot's cone and does not turn its
/// back, unless light goes through it. Others count as seeing the light for the engine, which
/// multiplies by 0, but no light reaches them.
bool can_light(const Light& light, const Receivers& receivers, int lane);

/// A method's visibility as pictures of visibility show it: 0 where the light cannot light a
/// receiver. Visibility is then continuous at terminators and cones' edges: surfaces that turn away
/// lie in their own shadow.
class LitVisibility final : public VisibilitySource {
 public:
  /// Keeps a reference to `source`, prepared for `light`.
  LitVisibility(const VisibilitySource& source, const Light& light)
      : source_(source), light_(light) {}

  void prepare(const Light& light) override { light_ = light; }
  void visibility(const Receivers& receivers, float* visibility) const override;

 private:
  const VisibilitySource& source_;
  Light light_;
};

}  // namespace relume

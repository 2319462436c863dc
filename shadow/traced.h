#pragma once

#include "core/relight/visibility.h"
#include "shadow/shadow_rays.h"

namespace relume {

/// One shadow ray a receiver, from its anchor: visibility is 0 or 1 (TR2007-600 sec. 4.2). Exact
/// for reduction method "all"; noise for sub-pixel geometry at few records. Receivers that the
/// light cannot light (outside a spot's cone, facing away) report 1 and cost nothing; the others
/// cost one Embree occlusion ray each.
class TracedVisibility final : public VisibilitySource {
 public:
  /// Keeps a reference to `tracer`.
  explicit TracedVisibility(const Tracer& tracer) : rays_(tracer) {}

  void prepare(const Light& light) override { rays_.aim(light); }
  void visibility(const Receivers& receivers, float* visibility) const override;

 private:
  ShadowRays rays_;
};

}  // namespace relume

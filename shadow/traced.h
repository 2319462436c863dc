#pragma once

#include "core/relight/visibility.h"
#include "core/trace/tracer.h"

namespace relume {

/// One shadow ray a receiver, from its anchor: visibility is 0 or 1 (TR2007-600 sec. 4.2). Exact
/// for reduction method "all"; noise for sub-pixel geometry at few records. Receivers that the
/// light cannot light (outside a spot's cone, facing away) report 1 and cost nothing; the others
/// cost one Embree occlusion ray each.
class TracedVisibility final : public VisibilitySource {
 public:
  /// Keeps a reference to `tracer`.
  explicit TracedVisibility(const Tracer& tracer) : tracer_(tracer) {}

  void prepare(const Light& light) override;
  void visibility(const Receivers& receivers, float* visibility) const override;

 private:
  bool sees(vec3 position, const vec3* normal, bool lit_from_behind, float bias) const;

  const Tracer& tracer_;
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

#pragma once

#include "core/scene/light.h"
#include "core/trace/tracer.h"

namespace relume {

/// Shadow rays to one light. Thread-safe.
class ShadowRays {
 public:
  /// Sees every light from everywhere until aim() is called. Keeps a reference to `tracer`.
  explicit ShadowRays(const Tracer& tracer) : tracer_(tracer) {}

  void aim(const Light& light);

  /// True when the light sees the point, or cannot light it: beyond its range, outside a spot's
  /// cone, or from behind the normal unless `lit_from_behind`. Such points cost nothing, others one
  /// occlusion ray. `normal` is null on strands; `bias` as in core/trace/ray_bias.h.
  bool sees(vec3 position, const vec3* normal, bool lit_from_behind, float bias) const;

 private:
  const Tracer& tracer_;
  Light light_;
  float reach_ = std::numeric_limits<float>::infinity();
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

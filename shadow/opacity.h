#pragma once

#include "core/relight/visibility.h"
#include "shadow/solid_shadow.h"

namespace relume {

struct OpacityParams {
  /// Of all maps of a light together, 4 bytes each. Finer maps follow strands more closely.
  uint64_t max_texels = uint64_t{4} << 20;
  /// Occluders this close before a receiver, in texels, do not count; beside its own bias.
  float bias_texels = 2;
};

/// Shadows from maps of what a light sees first. Each texel is one ray of the light: a strand or
/// leaf takes the texels whose centres it covers, so that its coverage is fractional over a few
/// texels however thin it is, without layers, and needs no law for how layers add up. A receiver
/// averages the texels within one of its place. Maps are fitted to the receivers; a light among
/// them has up to six. Solids are exact (SolidShadow). A light move draws all thin geometry but
/// strands deep in their shadow.
///
/// The rule for a receiver's own surroundings: geometry nearer than its bias and bias_texels texels
/// before it is not seen. Adding thin geometry never brightens. Cut-outs are drawn whole.
class OpacityVisibility final : public VisibilitySource {
 public:
  /// Keeps a reference to `scene`. `boxes`: bounds that hold all receivers that will be asked for;
  /// others count as seeing the light. Empty: the bounds of the thin geometry.
  OpacityVisibility(const Scene& scene, const std::vector<Bounds>& boxes,
                    const OpacityParams& params = {});

  void prepare(const Light& light) override;
  void visibility(const Receivers& receivers, float* visibility) const override;
  uint64_t memory_bytes() const override;

 private:
  OpacityParams params_;
  LookupKernels kernels_;
  SceneStrips thin_;
  StrandSet strands_;
  std::vector<uint8_t> hidden_;  ///< by point of the strands: deep in the shadow of solids
  std::vector<Bounds> boxes_;
  SolidShadow solids_;
  std::vector<DepthMap> maps_;
  std::vector<DepthLookup> lookups_;
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

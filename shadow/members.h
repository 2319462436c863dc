#pragma once

#include <vector>

#include "core/base/bytes_of.h"
#include "core/relight/receivers.h"
#include "shadow/shadow_rays.h"

namespace relume {

/// Traces up to `ray_count` rays, 1 or more, for lane `lane` of a group, whose stored members start
/// at `members`; returns the part that is not occluded. Without members: one ray from the anchor.
float trace_members(const ShadowRays& rays, const ReceiverGroup& group, int lane,
                    const Member* members, int ray_count);

/// Shadow rays from several of the samples that a receiver stands for: visibility is the part of
/// them that is not occluded. From all of them it is what traced shadows of all samples give, with
/// each sample at its record's shading. Receivers of one sample cost one ray.
class MemberVisibility final : public VisibilitySource {
 public:
  /// At most `rays` rays a receiver, 1 or more, evenly chosen among its stored members. Keeps
  /// references to both. Throws Error(input) when the cache keeps no members and rays > 1 would
  /// need them.
  MemberVisibility(const Tracer& tracer, const RelightCache& cache, int rays);

  /// Traces all rays, in parallel.
  void prepare(const Light& light) override { prepare_share(light, PixelShare::all); }
  void prepare_share(const Light& light, PixelShare share) override;
  void visibility(const Receivers& receivers, float* visibility) const override;
  std::span<const float> all_visibility() const override { return visibility_; }
  uint64_t memory_bytes() const override { return bytes_of(visibility_); }

 private:
  void trace_group(const ReceiverGroup& group, float* visibility) const;

  ViewReceivers view_;
  ShadowRays rays_;
  int ray_count_;
  std::vector<float> visibility_;
};

}  // namespace relume

#include "shadow/members.h"

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/parallel.h"

namespace relume {
namespace {

vec3 vector_at(const float* const (&arrays)[3], int i) {
  return {arrays[0][i], arrays[1][i], arrays[2][i]};
}

}  // namespace

float trace_members(const ShadowRays& rays, const ReceiverGroup& group, int lane,
                    const Member* members, int ray_count) {
  const Receivers& receivers = group.receivers;
  const Footprint& footprint = group.footprints[lane];
  const bool on_surface = receivers.normal[0] != nullptr;
  const vec3 anchor = vector_at(receivers.position, lane);
  const int count = std::min(ray_count, footprint.stored_members);
  if (count <= 1) {
    const vec3 normal = on_surface ? vector_at(receivers.normal, lane) : vec3(0);
    const bool seen = rays.sees(anchor, on_surface ? &normal : nullptr, receivers.lit_from_behind,
                                receivers.bias[lane]);
    return seen ? 1.0f : 0.0f;
  }
  // Stored positions are rounded: by half a step an axis, and to the anchor's last bits.
  const float bias = receivers.bias[lane] + member_scale(footprint) * 0x1p-14f;
  int seen = 0;
  for (int ray = 0; ray < count; ++ray) {
    const Member& member = members[(2 * ray + 1) * footprint.stored_members / (2 * count)];
    const bool sees = rays.sees(anchor + member.offset, on_surface ? &member.normal : nullptr,
                                receivers.lit_from_behind, bias);
    seen += sees ? 1 : 0;
  }
  return static_cast<float>(seen) / static_cast<float>(count);
}

MemberVisibility::MemberVisibility(const Tracer& tracer, const RelightCache& cache, int rays)
    : view_(cache), rays_(tracer), ray_count_(rays), visibility_(view_.count(), 1.0f) {
  CHECK_MSG(rays >= 1, "rays {}", rays);
  if (rays > 1 && view_.has_footprints() && !view_.has_members()) {
    throw input_error(view_.info().scene_name, "its cache keeps no members for shadow rays",
                      "prepare it with --members 255, or choose other shadows");
  }
}

void MemberVisibility::prepare_share(const Light& light, PixelShare share) {
  rays_.aim(light);
  parallel_for(view_.tile_count(), 1, [this, share](size_t begin, size_t end) {
    const auto visit = [this](const ReceiverGroup& group) {
      trace_group(group, &visibility_[group.receivers.first]);
    };
    for (size_t tile = begin; tile < end; ++tile) view_.visit_tile(tile, visit, share);
  });
}

void MemberVisibility::trace_group(const ReceiverGroup& group, float* visibility) const {
  const Member* members = group.members.data();
  for (int lane = 0; lane < group.receivers.count; ++lane) {
    if (group.receivers.weight[lane] > 0) {
      visibility[lane] = trace_members(rays_, group, lane, members, ray_count_);
    }
    members += group.footprints[lane].stored_members;
  }
}

void MemberVisibility::visibility(const Receivers& receivers, float* visibility) const {
  CHECK_MSG(receivers.first + receivers.count <= visibility_.size(), "{} {} {}", receivers.first,
            receivers.count, visibility_.size());
  std::copy_n(&visibility_[receivers.first], receivers.count, visibility);
}

}  // namespace relume

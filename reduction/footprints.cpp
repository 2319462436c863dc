#include "reduction/footprints.h"

namespace relume {
namespace {

dvec3 offset_from(vec3 anchor, const PlacedSample& sample) {
  return dvec3(sample.vector[0], sample.vector[1], sample.vector[2]) - dvec3(anchor);
}

void append_members(std::span<const PlacedSample> members, vec3 anchor, int stored,
                    TypedRows& out) {
  for (int i = 0; i < stored; ++i) {
    const size_t chosen = (2 * static_cast<size_t>(i) + 1) * members.size() / (2 * stored);
    const PlacedSample& sample = members[chosen];
    Member& member = out.members.emplace_back();
    member.offset = vec3(offset_from(anchor, sample));
    if (sample.normal < 0) continue;
    const float* normal = sample.vector + sample.normal;
    member.normal = vec3(normal[0], normal[1], normal[2]);
  }
}

}  // namespace

void append_footprint(std::span<const PlacedSample> members, vec3 anchor, int stored,
                      TypedRows& out) {
  Footprint& footprint = out.footprints.emplace_back();
  if (members.size() < 2) return;
  const auto count = static_cast<double>(members.size());
  dvec3 mean(0);
  for (const PlacedSample& member : members) mean += offset_from(anchor, member) / count;
  std::array<double, 6> sum{};
  for (const PlacedSample& member : members) {
    const dvec3 d = offset_from(anchor, member) - mean;
    const std::array<double, 6> square = {d.x * d.x, d.x * d.y, d.x * d.z,
                                          d.y * d.y, d.y * d.z, d.z * d.z};
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += square[i];
  }
  footprint.offset = vec3(mean);
  for (size_t i = 0; i < sum.size(); ++i) {
    footprint.covariance[i] = static_cast<float>(sum[i] / count);
  }
  footprint.samples = static_cast<int>(members.size());
  footprint.stored_members = std::min({stored, footprint.samples, max_members});
  append_members(members, anchor, footprint.stored_members, out);
}

}  // namespace relume

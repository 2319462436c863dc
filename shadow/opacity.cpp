#include "shadow/opacity.h"

namespace relume {

OpacityVisibility::OpacityVisibility(const Scene& scene, const std::vector<Bounds>& boxes,
                                     const OpacityParams& params)
    : params_(params),
      kernels_(best_lookup_kernels()),
      thin_(scene),
      strands_(thin_.strands()),
      boxes_(boxes),
      solids_(thin_, boxes) {
  if (boxes_.empty() && !thin_.empty()) boxes_.push_back(thin_.bounds());
}

uint64_t OpacityVisibility::memory_bytes() const {
  uint64_t bytes = solids_.memory_bytes() + strands_.memory_bytes() + hidden_.size();
  for (const DepthMap& map : maps_) bytes += map.memory_bytes();
  return bytes;
}

void OpacityVisibility::prepare(const Light& light) {
  light_ = light;
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
  solids_.prepare(light);
  lookups_.clear();
  if (thin_.empty()) return;
  const auto views = fit_light_planes(light, boxes_, thin_.bounds(), params_.max_texels);
  solids_.mark_hidden(strands_.points, hidden_);
  maps_.resize(views.size());
  for (size_t i = 0; i < views.size(); ++i) {
    maps_[i].reset(views[i]);
    maps_[i].draw_strands(strands_, hidden_);
    maps_[i].draw_triangles(thin_);
    lookups_.push_back(make_depth_lookup(maps_[i], params_.bias_texels));
  }
}

void OpacityVisibility::visibility(const Receivers& receivers, float* visibility) const {
  LookupChunk chunk;
  for (int first = 0; first < receivers.count; first += lookup_lanes) {
    chunk.load(receivers, first);
    chunk.mark_lit(light_, to_light_, cos_outer_);
    if (chunk.any_lit) {
      for (const DepthLookup& lookup : lookups_) {
        kernels_.look_up_depth(lookup, chunk.receivers(), chunk.passed);
      }
      solids_.apply(chunk);
    }
    chunk.store(visibility);
  }
}

}  // namespace relume

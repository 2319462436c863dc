#include "shadow/volume.h"

namespace relume {

VolumeVisibility::VolumeVisibility(const Scene& scene, const std::vector<Bounds>& boxes,
                                   const VolumeParams& params, const Bounds& region)
    : params_(params),
      kernels_(best_lookup_kernels()),
      grid_(make_volume_grid(SceneStrips(scene), params, region)),
      light_grid_(grid_),
      solids_(SceneStrips(scene), boxes) {}

uint64_t VolumeVisibility::memory_bytes() const {
  return grid_.memory_bytes() + light_grid_.memory_bytes() + solids_.memory_bytes();
}

void VolumeVisibility::prepare(const Light& light) {
  light_ = light;
  to_light_ = -normalize_or(light.direction, vec3(0, -1, 0));
  cos_outer_ = std::cos(radians_from_degrees(light.outer_angle_deg));
  solids_.prepare(light);
  light_grid_.sweep(light);
  lookup_ = light_grid_.lookup(params_.gap);
}

void VolumeVisibility::visibility(const Receivers& receivers, float* visibility) const {
  LookupChunk chunk;
  for (int first = 0; first < receivers.count; first += lookup_lanes) {
    chunk.load(receivers, first);
    chunk.mark_lit(light_, to_light_, cos_outer_);
    if (chunk.any_lit) {
      if (!grid_.occupied.empty()) {
        kernels_.look_up_light(lookup_, chunk.receivers(), chunk.passed);
      }
      solids_.apply(chunk);
    }
    chunk.store(visibility);
  }
}

}  // namespace relume

#pragma once

#include "core/relight/visibility.h"
#include "shadow/light_grid.h"
#include "shadow/solid_shadow.h"

namespace relume {

/// Shadows from voxel coverage. Thin geometry is cut into cells once a scene (VolumeGrid). A light
/// move sweeps the light through them (LightGrid); a receiver takes what comes to its place. The
/// cost is that of the cells and of one look-up a receiver, whatever the geometry. Solids by rays
/// where a small map of them leaves a doubt (SolidShadow).
///
/// A cell stops 1 - (1 - c / 2)^2, c = area seen / area of its face with each piece's clumping in
/// it, so that leaves larger than cells leak less where they lean through several. Between pieces
/// side by side (c) and anywhere (1 - exp(-c)); nearest to rays on hair and plants.
///
/// The rule for a receiver's own surroundings: geometry within params.gap cells along the ray is
/// not seen, nor is anything narrower than a cell resolved. Adding thin geometry within the grid
/// never brightens; geometry that moves the grid's bounds changes cells everywhere.
class VolumeVisibility final : public VisibilitySource {
 public:
  /// Keeps no reference to `scene`. `boxes`: where receivers are, as for SolidShadow. `region`:
  /// what the grid holds; empty = all thin geometry.
  VolumeVisibility(const Scene& scene, const std::vector<Bounds>& boxes,
                   const VolumeParams& params = {}, const Bounds& region = {});

  void prepare(const Light& light) override;
  void visibility(const Receivers& receivers, float* visibility) const override;
  uint64_t memory_bytes() const override;
  const VolumeGrid& grid() const { return grid_; }

 private:
  VolumeParams params_;
  LookupKernels kernels_;
  VolumeGrid grid_;
  LightGrid light_grid_;
  SolidShadow solids_;
  LightGridLookup lookup_{};
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

#pragma once

#include "core/relight/visibility.h"
#include "shadow/solid_shadow.h"
#include "shadow/volume_grid.h"

namespace relume {

/// Shadows from voxel coverage. Thin geometry is cut into cells once a scene (VolumeGrid); a light
/// move turns each cell's area into the fraction of the light's rays through the cell that it stops
/// and averages that, column by column, into coarser cells; a receiver multiplies what the slabs
/// of cells between it and the light let pass, fine ones near it, coarser ones farther off. Cost
/// does not depend on the geometry. Solids are exact (SolidShadow).
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
  struct Level {
    std::array<int, 3> size{};
    std::vector<uint32_t> occupied;  ///< coarser levels: cells with geometry below them
    std::vector<uint16_t> coverage;  ///< 65535 = all; one more than cells
  };

  void make_levels();
  void fill_finest();
  void fill_coarser(int level);

  VolumeParams params_;
  LookupKernels kernels_;
  VolumeGrid grid_;
  SolidShadow solids_;
  std::array<Level, VolumeLookup::max_levels> levels_;
  VolumeLookup lookup_{};
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

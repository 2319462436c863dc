#pragma once

#include <memory>

#include "core/relight/visibility.h"
#include "core/trace/tracer.h"
#include "shadow/traced.h"
#include "shadow/volume_grid.h"

namespace relume {

/// Levels of the pyramid of coverage: each has cells twice as large as the one before.
inline constexpr int volume_levels = 5;

/// Shadows from voxel coverage. Thin geometry is cut into cells once a scene (VolumeGrid); a light
/// move turns each cell's area into the fraction of the light's rays through the cell that it stops
/// and averages that into coarser cells; a receiver then multiplies what the cells between it and
/// the light let pass, fine ones near it, coarser ones farther off. Cost does not depend on the
/// geometry. Solids are exact: rays against them alone.
///
/// The rule for a receiver's own surroundings: geometry within one cell (finest level) along the
/// ray is not seen, so that a strand does not shadow itself. Adding thin geometry within the grid
/// never brightens; geometry that moves the grid's bounds changes cells everywhere.
class VolumeVisibility final : public VisibilitySource {
 public:
  /// Keeps no reference to `scene`, but the solids' materials refer to its shader table.
  VolumeVisibility(const Scene& scene, const VolumeParams& params = {}, const Bounds& region = {});

  void prepare(const Light& light) override;
  void visibility(const Receivers& receivers, float* visibility) const override;

  size_t memory_bytes() const;
  const VolumeGrid& grid() const { return grid_; }

 private:
  struct Level {
    std::array<int, 3> size{};
    std::vector<uint32_t> occupied;  ///< cells with geometry below them; finest level: the grid's
    std::vector<uint16_t> coverage;  ///< 65535 = all
  };

  void fill_finest();
  void fill_coarser(int level);
  float transmittance(vec3 position, float gap) const;

  VolumeGrid grid_;
  std::array<Level, volume_levels> levels_;
  std::unique_ptr<const Scene> solid_scene_;
  std::unique_ptr<const Tracer> solid_tracer_;
  std::unique_ptr<TracedVisibility> solids_;
  Light light_;
  vec3 to_light_{0, 1, 0};  ///< unit, against the light's direction
  float cos_outer_ = 0;     ///< spot
};

}  // namespace relume

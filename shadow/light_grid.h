#pragma once

#include "core/scene/light.h"
#include "shadow/lookup_kernel.h"
#include "shadow/volume_grid.h"

namespace relume {

/// How much of a light comes to each cell of a grid. A sweep starts at the light and goes outwards
/// slab by slab: what comes to a cell is what left the slab before it towards the light, between
/// four cells; what leaves it is that times what the cell lets pass. The cost is that of the cells,
/// not of receivers or geometry. Interpolation at each slab widens shadows as they get long.
class LightGrid {
 public:
  /// Keeps a reference to `grid`.
  explicit LightGrid(const VolumeGrid& grid) : grid_(grid), kernels_(best_lookup_kernels()) {}

  /// Fills all cells for a light, with all threads; the same for any number of them.
  void sweep(const Light& light);

  /// Valid until the next sweep. `gap`: see LightGridLookup.
  LightGridLookup lookup(float gap) const;
  uint64_t memory_bytes() const { return cells_.size() * sizeof(float); }

 private:
  /// Cells at one place along an axis.
  struct Slab {
    int axis;
    int place;
    int before;      ///< place of the slab that light comes from
    float distance;  ///< of its centre from the light, cells; parallel: the order
  };

  void fill_cells();
  std::vector<Slab> order_slabs() const;
  void sweep_slab(const Slab& slab);

  const VolumeGrid& grid_;
  LookupKernels kernels_;
  bool parallel_ = false;
  vec3 light_{0};  ///< in cells, or the unit vector towards a parallel light
  std::vector<float> cells_;
};

}  // namespace relume

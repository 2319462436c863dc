#pragma once

#include <cstdint>

#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int lookup_lanes = 16;

/// Sixteen receivers as lookups take them; every value finite.
struct LookupReceivers {
  const float* position[3];     ///< world
  const float* bias;            ///< world units
  const float* normal[3] = {};  ///< unit; all null on strands
};

/// What a lookup needs of a depth map; see LightPlane, which it mirrors, and DepthMap.
struct DepthLookup {
  const float* texels;
  int width;
  int height;
  float origin[3];
  float axes[3][3];  ///< x, y, z
  bool perspective;
  float scale;
  float offset_u;
  float offset_v;
  float far;
  float near;
  float bias_texels;  ///< added to each receiver's bias, in texels at its depth
};

/// A grid of light that was swept from a light outwards; see LightGrid, which it mirrors.
struct LightGridLookup {
  const float* cells;  ///< of the light, what leaves each cell on the far side; x fastest
  int size[3];
  float origin[3];  ///< world
  float inverse_cell;
  bool parallel;
  float light[3];  ///< in cells, or the unit vector towards a parallel light
  float gap;       ///< cells along the longest axis that are not seen before a receiver
};

/// A row of cells of a slab and the slab before it, as a sweep takes them. Cell j of the row lies
/// at first + j * step; the light comes to it from place start + slope * j of the rows before[0]
/// and before[1], between which it lies at `part`.
struct SweepRow {
  int first;
  int step;
  int begin;
  int end;
  int before[2];
  float part;
  float start;
  float slope;
  int low;  ///< the cells before that count
  int high;
};

struct LookupKernels {
  /// passed[lane] *= the fraction of a square of 2 x 2 texels around the lane's place that lets the
  /// light through; lanes that the map's view does not hold stay as they are.
  void (*look_up_depth)(const DepthLookup& map, const LookupReceivers& receivers, float* passed);
  /// Sorts lanes by a map of solids: state[lane] = 1 where all 3 x 3 texels around the lane's place
  /// show something nearer to the light than it, by more than the bias; 0 where none shows anything
  /// before it, on surfaces before its tangent plane by a twentieth of a texel; 2 elsewhere. Lanes
  /// that the map's view does not hold stay as they are.
  void (*sort_by_depth)(const DepthLookup& map, const LookupReceivers& receivers, float* state);
  /// Cells of a row, each what it lets pass, become what leaves them on the far side.
  void (*sweep_row)(float* cells, const SweepRow& row);
  /// passed[lane] = what comes to the lane's place through the grid.
  void (*look_up_light)(const LightGridLookup& grid, const LookupReceivers& receivers,
                        float* passed);
};

/// The kernels of `set` (already chosen, not automatic). Thread-safe, no allocation.
LookupKernels lookup_kernels(InstructionSet set);

/// Those of the best instruction set of this machine.
const LookupKernels& best_lookup_kernels();

namespace scalar {
LookupKernels make_lookup_kernels();
}
namespace sse42 {
LookupKernels make_lookup_kernels();
}
namespace avx2 {
LookupKernels make_lookup_kernels();
}
namespace avx512 {
LookupKernels make_lookup_kernels();
}

}  // namespace relume

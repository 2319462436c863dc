#pragma once

#include <cstdint>

#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int lookup_lanes = 16;

/// Sixteen receivers as lookups take them; every value finite.
struct LookupReceivers {
  const float* position[3];  ///< world
  const float* bias;         ///< world units
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

/// What a march needs of a pyramid of coverage; see VolumeVisibility.
struct VolumeLookup {
  static constexpr int max_levels = 5;
  const uint16_t* coverage[max_levels];  ///< x fastest, 65535 = all; a number more behind the last
  int size[3];                           ///< cells of the finest level, multiples of 16
  float origin[3];                       ///< world
  float inverse_cell;
  bool parallel;
  float light[3];  ///< world position, or the unit vector towards a parallel light
  float gap;       ///< cells along the ray that are skipped at the receiver
  int steps;       ///< slabs a level, but for the last
};

struct LookupKernels {
  /// passed[lane] *= the fraction of a square of 2 x 2 texels around the lane's place that lets the
  /// light through; lanes that the map's view does not hold stay as they are.
  void (*look_up_depth)(const DepthLookup& map, const LookupReceivers& receivers, float* passed);
  /// Sorts lanes by a map of solids: state[lane] = 1 where all 3 x 3 texels around the lane's place
  /// show something nearer to the light than it, by more than the bias; 0 where none shows anything
  /// nearer; 2 elsewhere. Lanes that the map's view does not hold stay as they are.
  void (*sort_by_depth)(const DepthLookup& map, const LookupReceivers& receivers, float* state);
  /// passed[lane] = what the cells between the lane's place and the light let through.
  void (*march_volume)(const VolumeLookup& volume, const LookupReceivers& receivers, float* passed);
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

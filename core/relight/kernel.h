#pragma once

#include <cstdint>

#include "core/simd/instruction_set.h"

namespace relume {

/// How a light reaches a record; each has a kernel of its own, so that a scene pays for what it uses.
enum class LightKernel : int { point, point_constant, spot, spot_constant, directional, count };

/// A light as kernels see it: plain floats, world space.
struct KernelLight {
  LightKernel kind = LightKernel::point;
  float position[3] = {};
  float to_light[3] = {};          ///< unit, directional: towards the light; spot: -axis
  float cos_outer = 0;
  float inverse_cos_range = 0;     ///< 1 / (cos_inner - cos_outer)
  float min_distance_squared = 0;  ///< distances below are clamped: no singularity at the light
};

/// One block: 16 pixels, one per lane (see PackedBlock).
struct KernelBlock {
  const float* data;
  const uint16_t* slots;        ///< per type
  const int* shaders;           ///< per type: index into the shader list
  const int* widths;            ///< per type: floats per sample vector
  int type_count;
  const float* visibility;      ///< 16 per slot, in slot order, or null: all 1
  float eye[3];
  float* rgb;                   ///< out: 3 x 16 sums
};

using ShadeBlock = void (*)(const KernelBlock&, const KernelLight&);

/// The block kernel of `set` (already chosen, not automatic).
ShadeBlock block_kernel(InstructionSet set);

namespace scalar {
void shade_block(const KernelBlock&, const KernelLight&);
}
namespace sse42 {
void shade_block(const KernelBlock&, const KernelLight&);
}
namespace avx2 {
void shade_block(const KernelBlock&, const KernelLight&);
}
namespace avx512 {
void shade_block(const KernelBlock&, const KernelLight&);
}

}  // namespace relume

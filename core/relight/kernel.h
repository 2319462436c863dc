#pragma once

#include <cstdint>

#include "core/shade/kernel_light.h"
#include "core/simd/instruction_set.h"

namespace relume {

/// One block: 16 pixels, one per lane (see PackedBlock).
struct KernelBlock {
  const float* data;
  const uint16_t* slots;  ///< per type
  const int* shaders;     ///< per type: index into the shader list
  const int* widths;      ///< per type: floats per sample vector
  int type_count;
  const float* visibility;  ///< 16 per slot, in slot order, or null: all 1
  float eye[3];
  float* rgb;  ///< out: 3 x 16 sums
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

#include "core/relight/kernel.h"

namespace relume {

ShadeBlocks block_kernel(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::shade_blocks;
    case InstructionSet::avx2:
      return avx2::shade_blocks;
    case InstructionSet::sse42:
      return sse42::shade_blocks;
#endif
    default:
      return scalar::shade_blocks;
  }
}

}  // namespace relume

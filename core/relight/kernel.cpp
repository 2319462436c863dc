#include "core/relight/kernel.h"

namespace relume {

ShadeBlock block_kernel(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::shade_block;
    case InstructionSet::avx2:
      return avx2::shade_block;
    case InstructionSet::sse42:
      return sse42::shade_block;
#endif
    default:
      return scalar::shade_block;
  }
}

}  // namespace relume

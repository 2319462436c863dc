#include "core/relight/kernel.h"

namespace relume {

BlockKernels block_kernels(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::make_block_kernels();
    case InstructionSet::avx2:
      return avx2::make_block_kernels();
    case InstructionSet::sse42:
      return sse42::make_block_kernels();
#endif
    default:
      return scalar::make_block_kernels();
  }
}

}  // namespace relume

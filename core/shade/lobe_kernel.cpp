#include "core/shade/lobe_kernel.h"

namespace relume {

LobeKernels lobe_kernels(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::make_lobe_kernels();
    case InstructionSet::avx2:
      return avx2::make_lobe_kernels();
    case InstructionSet::sse42:
      return sse42::make_lobe_kernels();
#endif
    default:
      return scalar::make_lobe_kernels();
  }
}

}  // namespace relume

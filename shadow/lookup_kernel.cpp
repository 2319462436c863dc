#include "shadow/lookup_kernel.h"

namespace relume {

LookupKernels lookup_kernels(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::make_lookup_kernels();
    case InstructionSet::avx2:
      return avx2::make_lookup_kernels();
    case InstructionSet::sse42:
      return sse42::make_lookup_kernels();
#endif
    default:
      return scalar::make_lookup_kernels();
  }
}

const LookupKernels& best_lookup_kernels() {
  static const LookupKernels kernels =
      lookup_kernels(choose_instruction_set(InstructionSet::automatic));
  return kernels;
}

}  // namespace relume

#include "core/simd/row_kernels.h"

namespace relume {

RowKernels row_kernels(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::make_row_kernels();
    case InstructionSet::avx2:
      return avx2::make_row_kernels();
    case InstructionSet::sse42:
      return sse42::make_row_kernels();
#endif
    default:
      return scalar::make_row_kernels();
  }
}

const RowKernels& best_row_kernels() {
  static const RowKernels kernels = row_kernels(choose_instruction_set(InstructionSet::automatic));
  return kernels;
}

}  // namespace relume

#include "shadow/coverage_kernel.h"

namespace relume {

CoverageKernels coverage_kernels(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::avx512:
      return avx512::make_coverage_kernels();
    case InstructionSet::avx2:
      return avx2::make_coverage_kernels();
    case InstructionSet::sse42:
      return sse42::make_coverage_kernels();
#endif
    default:
      return scalar::make_coverage_kernels();
  }
}

}  // namespace relume

#include "core/simd/instruction_set.h"

namespace relume {

bool is_supported(InstructionSet set) {
  switch (set) {
    case InstructionSet::automatic:
    case InstructionSet::scalar:
      return true;
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::sse42:
      return __builtin_cpu_supports("sse4.2");
    case InstructionSet::avx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case InstructionSet::avx512:
      return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
             __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl") &&
             __builtin_cpu_supports("fma");
#else
    case InstructionSet::sse42:
    case InstructionSet::avx2:
    case InstructionSet::avx512:
      return false;
#endif
  }
  return false;
}

InstructionSet choose_instruction_set(InstructionSet wanted) {
  if (wanted == InstructionSet::automatic) wanted = InstructionSet::avx512;
  for (const InstructionSet set :
       {InstructionSet::avx512, InstructionSet::avx2, InstructionSet::sse42}) {
    if (static_cast<int>(set) <= static_cast<int>(wanted) && is_supported(set)) return set;
  }
  return InstructionSet::scalar;
}

}  // namespace relume

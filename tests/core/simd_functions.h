#pragma once

#include "core/simd/instruction_set.h"

namespace relume::test {

/// The functions of core/simd/pack.h over arrays, as built for one instruction set. `count` is a
/// multiple of 16.
struct SimdFunctions {
  void (*log2)(const float* x, float* out, int count);
  void (*exp2)(const float* x, float* out, int count);
  void (*rsqrt)(const float* x, float* out, int count);
  void (*sqrt)(const float* x, float* out, int count);
  void (*pow_unit)(const float* x, const float* e, float* out, int count);
  void (*fma)(const float* a, const float* b, const float* c, float* out, int count);
  void (*minimum)(const float* a, const float* b, float* out, int count);
  void (*maximum)(const float* a, const float* b, float* out, int count);
  int width;
};

/// Those of `set`; null functions when this build lacks it.
SimdFunctions simd_functions(InstructionSet set);

}  // namespace relume::test

namespace relume::scalar {
test::SimdFunctions simd_functions();
}
namespace relume::sse42 {
test::SimdFunctions simd_functions();
}
namespace relume::avx2 {
test::SimdFunctions simd_functions();
}
namespace relume::avx512 {
test::SimdFunctions simd_functions();
}

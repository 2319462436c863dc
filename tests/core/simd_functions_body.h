#pragma once

// Included by one small source file per instruction set, which defines RELUME_ISA. No test
// framework and no standard library here: their inline functions must not be built for that set.

#include "core/simd/pack.h"
#include "tests/core/simd_functions.h"

namespace relume::RELUME_ISA {

using F = Pack<native_width>;

template <F (*function)(F)>
void map(const float* x, float* out, int count) {
  for (int i = 0; i < count; i += native_width) function(F::load(x + i)).store(out + i);
}

template <F (*function)(F, F)>
void map(const float* a, const float* b, float* out, int count) {
  for (int i = 0; i < count; i += native_width) {
    function(F::load(a + i), F::load(b + i)).store(out + i);
  }
}

inline void map_fma(const float* a, const float* b, const float* c, float* out, int count) {
  for (int i = 0; i < count; i += native_width) {
    fma(F::load(a + i), F::load(b + i), F::load(c + i)).store(out + i);
  }
}

test::SimdFunctions simd_functions() {
  return {map<log2<native_width>>, map<exp2<native_width>>,     map<rsqrt<native_width>>,
          map<sqrt<native_width>>, map<pow_unit<native_width>>, map_fma,
          map<min<native_width>>,  map<max<native_width>>,      native_width};
}

}  // namespace relume::RELUME_ISA

#pragma once

// Loops over the sums of whole blocks; part of the kernel sources, see core/simd/pack.h for what
// may be called here.

#include "core/relight/kernel.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

inline void add_layer(const float* layer, const float* weight, int blocks, float* sums) {
  using F = Pack<native_width>;
  const F weights[3] = {F(weight[0]), F(weight[1]), F(weight[2])};
  for (int b = 0; b < blocks; ++b) {
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      for (int lane = 0; lane < block_lanes; lane += native_width) {
        const int i = b * block_floats + c * block_lanes + lane;
        (F::load(sums + i) + weights[c] * F::load(layer + i)).store(sums + i);
      }
    }
  }
}

inline int make_finite(int blocks, float* sums) {
  using I = Lanes<int32_t, native_width>::type;
  const auto exponent = [](const float* p) {
    return bits_of(Pack<native_width>::load(p)) & 0x7f800000;
  };
  I bad{};
  for (int i = 0; i < blocks * block_floats; i += native_width) {
    bad |= I(exponent(sums + i) == 0x7f800000);
  }
  int32_t lanes_bad[native_width];
  __builtin_memcpy(lanes_bad, &bad, sizeof(bad));
  int32_t any = 0;
  for (const int32_t lane : lanes_bad) any |= lane;
  if (any == 0) [[likely]]
    return 0;
  int replaced = 0;
  for (int i = 0; i < blocks * block_floats; ++i) {
    if (__builtin_isfinite(sums[i])) continue;
    sums[i] = 0;
    ++replaced;
  }
  return replaced;
}

inline void stream_layer(const float* sums, int blocks, float* layer) {
  using F = Pack<native_width>;
  for (int i = 0; i < blocks * block_floats; i += native_width) {
    stream(F::load(sums + i), layer + i);
  }
}

}  // namespace relume::RELUME_ISA

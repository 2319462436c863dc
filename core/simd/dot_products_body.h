#pragma once

// Included by one tiny source file per instruction set: see core/simd/pack.h.

#include "core/simd/dot_products.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

/// Sum of the lanes, in lane order.
template <int W>
float sum_lanes(Pack<W> a) {
  if constexpr (W == 1) {
    return a.v;
  } else {
    float lanes[W];
    a.store(lanes);
    for (int half = W / 2; half > 0; half /= 2) {
      for (int i = 0; i < half; ++i) lanes[i] += lanes[i + half];
    }
    return lanes[0];
  }
}

void dot_products(const float* a, int a_rows, int a_stride, const float* b, int b_rows,
                  int b_stride, int length, float* out, int out_stride) {
  using P = Pack<native_width>;
  for (int i = 0; i < a_rows; ++i) {
    const float* row = a + i * a_stride;
    int j = 0;
    for (; j + 4 <= b_rows; j += 4) {  // four columns at a time hide the latency of the sums
      const float* b0 = b + j * b_stride;
      const float* b1 = b0 + b_stride;
      const float* b2 = b1 + b_stride;
      const float* b3 = b2 + b_stride;
      P s0(0.0f), s1(0.0f), s2(0.0f), s3(0.0f);
      for (int x = 0; x < length; x += native_width) {
        const P v = P::load(row + x);
        s0 = fma(v, P::load(b0 + x), s0);
        s1 = fma(v, P::load(b1 + x), s1);
        s2 = fma(v, P::load(b2 + x), s2);
        s3 = fma(v, P::load(b3 + x), s3);
      }
      float* o = out + i * out_stride + j;
      o[0] = sum_lanes(s0);
      o[1] = sum_lanes(s1);
      o[2] = sum_lanes(s2);
      o[3] = sum_lanes(s3);
    }
    for (; j < b_rows; ++j) {
      P s(0.0f);
      for (int x = 0; x < length; x += native_width) {
        s = fma(P::load(row + x), P::load(b + j * b_stride + x), s);
      }
      out[i * out_stride + j] = sum_lanes(s);
    }
  }
}

}  // namespace relume::RELUME_ISA

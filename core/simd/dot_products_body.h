#pragma once

// Included by one tiny source file per instruction set: see core/simd/pack.h.

#include "core/simd/dot_products.h"
#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

/// Sum of the lanes: each half added to the other until one is left.
template <int W>
float sum_lanes(Pack<W> a) {
  if constexpr (W == 1) {
    return a.v;
  } else if constexpr (W == 4) {
    const auto pairs = a.v + __builtin_shufflevector(a.v, a.v, 2, 3, -1, -1);
    return pairs[0] + pairs[1];
  } else if constexpr (W == 8) {
    return sum_lanes(make_pack<4>(__builtin_shufflevector(a.v, a.v, 0, 1, 2, 3) +
                                  __builtin_shufflevector(a.v, a.v, 4, 5, 6, 7)));
  } else {
    static_assert(W == 16);
    return sum_lanes(make_pack<8>(__builtin_shufflevector(a.v, a.v, 0, 1, 2, 3, 4, 5, 6, 7) +
                                  __builtin_shufflevector(a.v, a.v, 8, 9, 10, 11, 12, 13, 14, 15)));
  }
}

/// Products of `rows` rows of a, 1 or 2, with four of b: enough sums at a time to hide the latency
/// of each, and every load of b used for all rows.
template <int rows>
void dot_block(const float* a, int a_stride, const float* b, int b_stride, int length, float* out,
               int out_stride) {
  using P = Pack<native_width>;
  const float* a1 = a + (rows - 1) * a_stride;
  P s00(0.0f), s01(0.0f), s02(0.0f), s03(0.0f);
  P s10(0.0f), s11(0.0f), s12(0.0f), s13(0.0f);
  for (int x = 0; x < length; x += native_width) {
    const P b0 = P::load(b + x);
    const P b1 = P::load(b + b_stride + x);
    const P b2 = P::load(b + 2 * b_stride + x);
    const P b3 = P::load(b + 3 * b_stride + x);
    const P v = P::load(a + x);
    s00 = fma(v, b0, s00);
    s01 = fma(v, b1, s01);
    s02 = fma(v, b2, s02);
    s03 = fma(v, b3, s03);
    if constexpr (rows == 2) {
      const P w = P::load(a1 + x);
      s10 = fma(w, b0, s10);
      s11 = fma(w, b1, s11);
      s12 = fma(w, b2, s12);
      s13 = fma(w, b3, s13);
    }
  }
  out[0] = sum_lanes(s00);
  out[1] = sum_lanes(s01);
  out[2] = sum_lanes(s02);
  out[3] = sum_lanes(s03);
  if constexpr (rows == 2) {
    out += out_stride;
    out[0] = sum_lanes(s10);
    out[1] = sum_lanes(s11);
    out[2] = sum_lanes(s12);
    out[3] = sum_lanes(s13);
  }
}

void dot_products(const float* a, int a_rows, int a_stride, const float* b, int b_rows,
                  int b_stride, int length, float* out, int out_stride) {
  using P = Pack<native_width>;
  const int blocked = b_rows / 4 * 4;
  for (int i = 0; i < a_rows; i += 2) {
    const float* row = a + i * a_stride;
    for (int j = 0; j < blocked; j += 4) {
      const auto block = i + 1 < a_rows ? dot_block<2> : dot_block<1>;
      block(row, a_stride, b + j * b_stride, b_stride, length, out + i * out_stride + j,
            out_stride);
    }
  }
  for (int i = 0; i < a_rows; ++i) {
    for (int j = blocked; j < b_rows; ++j) {
      P s(0.0f);
      for (int x = 0; x < length; x += native_width) {
        s = fma(P::load(a + i * a_stride + x), P::load(b + j * b_stride + x), s);
      }
      out[i * out_stride + j] = sum_lanes(s);
    }
  }
}

}  // namespace relume::RELUME_ISA

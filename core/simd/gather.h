#pragma once

// Lanes that go their own ways: masks as values and loads from an address a lane. Include with
// RELUME_ISA defined, as core/simd/pack.h says.

#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

template <int W>
Mask<W> operator&(Mask<W> a, Mask<W> b) {
  if constexpr (W == 1) {
    return {a.v && b.v};
  } else {
    return {a.v & b.v};
  }
}

template <int W>
Mask<W> operator!(Mask<W> a) {
  if constexpr (W == 1) {
    return {!a.v};
  } else {
    return {~a.v};
  }
}

/// True when any lane of the mask is set.
template <int W>
bool any(Mask<W> mask) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return _mm512_test_epi32_mask((__m512i)mask.v, (__m512i)mask.v) != 0;
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return _mm256_movemask_ps((__m256)mask.v) != 0;
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return _mm_movemask_ps((__m128)mask.v) != 0;
#endif
  if constexpr (W == 1) {
    return mask.v;
  } else {
    int32_t sum = 0;
    for (int i = 0; i < W; ++i) sum |= mask.v[i];
    return sum != 0;
  }
}

/// Per lane: mask ? a : b, of integers.
template <int W>
typename Lanes<int32_t, W>::type select_int(Mask<W> mask, typename Lanes<int32_t, W>::type a,
                                            typename Lanes<int32_t, W>::type b) {
  return mask.v ? a : b;
}

/// Per lane: base[index].
template <int W>
Pack<W> gather(const float* base, typename Lanes<int32_t, W>::type index) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return make_pack<W>(_mm512_i32gather_ps((__m512i)index, base, 4));
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return make_pack<W>(_mm256_i32gather_ps(base, (__m256i)index, 4));
#endif
  if constexpr (W == 1) {
    return make_pack<W>(base[index]);
  } else {
    Pack<W> r;
    for (int i = 0; i < W; ++i) r.v[i] = base[index[i]];
    return r;
  }
}

/// Per lane: the 16-bit number base[index]; one more must be readable behind the last.
template <int W>
Pack<W> gather_short(const uint16_t* base, typename Lanes<int32_t, W>::type index) {
#if defined(__AVX512F__)
  if constexpr (W == 16) {
    const __m512i both = _mm512_i32gather_epi32((__m512i)index, base, 2);
    return make_pack<W>(_mm512_cvtepi32_ps(_mm512_and_si512(both, _mm512_set1_epi32(0xffff))));
  }
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) {
    const auto* words = reinterpret_cast<const int*>(base);
    const __m256i both = _mm256_i32gather_epi32(words, (__m256i)index, 2);
    return make_pack<W>(_mm256_cvtepi32_ps(_mm256_and_si256(both, _mm256_set1_epi32(0xffff))));
  }
#endif
  if constexpr (W == 1) {
    return make_pack<W>(static_cast<float>(base[index]));
  } else {
    Pack<W> r;
    for (int i = 0; i < W; ++i) r.v[i] = static_cast<float>(base[index[i]]);
    return r;
  }
}

}  // namespace relume::RELUME_ISA

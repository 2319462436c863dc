#pragma once

// The vector unit, wrapped once. A source file that holds kernels for one instruction set defines
// RELUME_ISA to that set's name before including this header. Everything here lies in a namespace
// of that name: the linker can never merge code built for different instruction sets. Such a file
// must not call inline functions from elsewhere (std::, glm::) in its kernels, for the same reason.

#ifndef RELUME_ISA
#error "define RELUME_ISA (scalar, sse42, avx2, avx512) before including core/simd/pack.h"
#endif

#if defined(__SSE4_2__)
#include <immintrin.h>
#endif

#include <cstdint>

namespace relume::RELUME_ISA {

#if defined(__AVX512F__)
inline constexpr int native_width = 16;
#elif defined(__AVX2__)
inline constexpr int native_width = 8;
#elif defined(__SSE4_2__) || defined(__ARM_NEON)
inline constexpr int native_width = 4;
#else
inline constexpr int native_width = 1;
#endif

/// Storage of W lanes: a compiler vector, or a plain number for W = 1.
template <class T, int W>
struct Lanes {
  typedef T type __attribute__((vector_size(sizeof(T) * W)));
};
template <class T>
struct Lanes<T, 1> {
  using type = T;
};

/// An explicit mask: one bool per lane, as the compiler's all-ones or all-zeros integers.
template <int W>
struct Mask {
  typename Lanes<int32_t, W>::type v;
};
template <>
struct Mask<1> {
  bool v;
};

/// W floats. Arithmetic is lane by lane and IEEE; there is no implicit contraction.
template <int W>
struct Pack {
  using Vector = typename Lanes<float, W>::type;
  Vector v;

  Pack() = default;
  Pack(float x) : v(x - Vector{}) {}  // NOLINT: broadcast is meant to be implicit
  explicit Pack(Vector x, int) : v(x) {}

  static Pack load(const float* p) {
    Pack r;
    __builtin_memcpy(&r.v, p, sizeof(Vector));
    return r;
  }
  void store(float* p) const { __builtin_memcpy(p, &v, sizeof(Vector)); }
};

/// Writes to an address aligned to the pack's size, past the caches where the machine can: for what
/// is not read again soon. finish_streams() before other threads read it.
template <int W>
void stream(Pack<W> a, float* p) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return _mm512_stream_ps(p, a.v);
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return _mm256_stream_ps(p, a.v);
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return _mm_stream_ps(p, a.v);
#endif
  a.store(p);
}
inline void finish_streams() {
#if defined(__SSE4_2__)
  _mm_sfence();
#endif
}

template <int W>
Pack<W> make_pack(typename Pack<W>::Vector v) {
  return Pack<W>(v, 0);
}

template <int W>
Pack<W> operator+(Pack<W> a, Pack<W> b) {
  return make_pack<W>(a.v + b.v);
}
template <int W>
Pack<W> operator-(Pack<W> a, Pack<W> b) {
  return make_pack<W>(a.v - b.v);
}
template <int W>
Pack<W> operator*(Pack<W> a, Pack<W> b) {
  return make_pack<W>(a.v * b.v);
}
template <int W>
Pack<W> operator/(Pack<W> a, Pack<W> b) {
  return make_pack<W>(a.v / b.v);
}
template <int W>
Mask<W> operator>(Pack<W> a, Pack<W> b) {
  return {a.v > b.v};
}
template <int W>
Mask<W> operator<(Pack<W> a, Pack<W> b) {
  return {a.v < b.v};
}

/// Per lane: mask ? a : b.
template <int W>
Pack<W> select(Mask<W> mask, Pack<W> a, Pack<W> b) {
  return make_pack<W>(mask.v ? a.v : b.v);
}

/// One bit a lane, lane 0 the lowest.
template <int W>
unsigned bits_of(Mask<W> mask) {
#if defined(__AVX512DQ__)
  if constexpr (W == 16) return _mm512_movepi32_mask((__m512i)mask.v);
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return static_cast<unsigned>(_mm256_movemask_ps((__m256)mask.v));
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return static_cast<unsigned>(_mm_movemask_ps((__m128)mask.v));
#endif
  if constexpr (W == 1) {
    return mask.v ? 1 : 0;
  } else {
    unsigned bits = 0;
    for (int i = 0; i < W; ++i) bits |= mask.v[i] != 0 ? 1u << i : 0u;
    return bits;
  }
}

/// a > b ? a : b: a NaN in `a` gives b. GCC 12 does not find the instruction by itself.
template <int W>
Pack<W> max(Pack<W> a, Pack<W> b) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return make_pack<W>(_mm512_max_ps(a.v, b.v));
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return make_pack<W>(_mm256_max_ps(a.v, b.v));
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return make_pack<W>(_mm_max_ps(a.v, b.v));
#endif
  return make_pack<W>(a.v > b.v ? a.v : b.v);
}
/// a < b ? a : b: a NaN in `a` gives b. GCC 12 does not find the instruction by itself.
template <int W>
Pack<W> min(Pack<W> a, Pack<W> b) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return make_pack<W>(_mm512_min_ps(a.v, b.v));
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return make_pack<W>(_mm256_min_ps(a.v, b.v));
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return make_pack<W>(_mm_min_ps(a.v, b.v));
#endif
  return make_pack<W>(a.v < b.v ? a.v : b.v);
}

/// a * b + c, rounded once where the machine has fused multiply-add and twice elsewhere.
template <int W>
Pack<W> fma(Pack<W> a, Pack<W> b, Pack<W> c) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return make_pack<W>(_mm512_fmadd_ps(a.v, b.v, c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 8) return make_pack<W>(_mm256_fmadd_ps(a.v, b.v, c.v));
#endif
  return make_pack<W>(a.v * b.v + c.v);
}

template <int W>
Pack<W> sqrt(Pack<W> a) {
#if defined(__AVX512F__)
  if constexpr (W == 16) return make_pack<W>(_mm512_sqrt_ps(a.v));
#endif
#if defined(__AVX2__)
  if constexpr (W == 8) return make_pack<W>(_mm256_sqrt_ps(a.v));
#endif
#if defined(__SSE4_2__)
  if constexpr (W == 4) return make_pack<W>(_mm_sqrt_ps(a.v));
#endif
  if constexpr (W == 1) {
    return make_pack<W>(__builtin_sqrtf(a.v));
  } else {
    Pack<W> r;
    for (int i = 0; i < W; ++i) r.v[i] = __builtin_sqrtf(a.v[i]);
    return r;
  }
}

/// 1 / sqrt(a) for a in [2^-120, 2^120]; relative error <= 4e-7 (estimate and one Newton step where
/// the machine has an estimate, else exact square root and division).
template <int W>
Pack<W> rsqrt(Pack<W> a) {
#if defined(__SSE4_2__)
  if constexpr (W > 1) {
    Pack<W> estimate;
#if defined(__AVX512F__)
    if constexpr (W == 16) estimate = make_pack<W>(_mm512_rsqrt14_ps(a.v));
#endif
#if defined(__AVX2__)
    if constexpr (W == 8) estimate = make_pack<W>(_mm256_rsqrt_ps(a.v));
#endif
    if constexpr (W == 4) estimate = make_pack<W>(_mm_rsqrt_ps(a.v));
    const Pack<W> minus_half = Pack<W>(-0.5f) * a * estimate;
    return estimate * fma(minus_half, estimate, Pack<W>(1.5f));
  }
#endif
  return Pack<W>(1.0f) / sqrt(a);
}

/// Integer views of the bits, for exponent arithmetic.
template <int W>
typename Lanes<int32_t, W>::type bits_of(Pack<W> a) {
  typename Lanes<int32_t, W>::type r;
  __builtin_memcpy(&r, &a.v, sizeof(r));
  return r;
}
template <int W>
Pack<W> from_bits(typename Lanes<int32_t, W>::type bits) {
  Pack<W> r;
  __builtin_memcpy(&r.v, &bits, sizeof(bits));
  return r;
}
template <int W>
Pack<W> to_float(typename Lanes<int32_t, W>::type i) {
  if constexpr (W == 1) {
    return make_pack<W>(static_cast<float>(i));
  } else {
    return make_pack<W>(__builtin_convertvector(i, typename Lanes<float, W>::type));
  }
}
/// Truncation towards zero; |a| < 2^31.
template <int W>
typename Lanes<int32_t, W>::type to_int(Pack<W> a) {
  if constexpr (W == 1) {
    return static_cast<int32_t>(a.v);
  } else {
    return __builtin_convertvector(a.v, typename Lanes<int32_t, W>::type);
  }
}

/// log2(x) for normal x > 0: error <= 2e-7 max(1, |log2 x|), and <= 4e-7 |log2 x| for x near 1.
/// Reduction to [sqrt(1/2), sqrt(2)) and the Cephes logf polynomial.
template <int W>
Pack<W> log2(Pack<W> x) {
  using Int = typename Lanes<int32_t, W>::type;
  const Int offset = Int{} + 0x3f3504f3;  // sqrt(1/2)
  const Int bits = bits_of(x) - offset;
  const Pack<W> exponent = to_float<W>(bits >> 23);
  const Pack<W> m = from_bits<W>((bits & 0x007fffff) + offset) - Pack<W>(1.0f);
  const Pack<W> m2 = m * m;
  Pack<W> p = Pack<W>(7.0376836292e-2f);
  p = fma(p, m, Pack<W>(-1.1514610310e-1f));
  p = fma(p, m, Pack<W>(1.1676998740e-1f));
  p = fma(p, m, Pack<W>(-1.2420140846e-1f));
  p = fma(p, m, Pack<W>(1.4249322787e-1f));
  p = fma(p, m, Pack<W>(-1.6668057665e-1f));
  p = fma(p, m, Pack<W>(2.0000714765e-1f));
  p = fma(p, m, Pack<W>(-2.4999993993e-1f));
  p = fma(p, m, Pack<W>(3.3333331174e-1f));
  const Pack<W> tail = fma(m * m2, p, Pack<W>(-0.5f) * m2);
  const Pack<W> log2e(1.44269504f);
  return fma(m, log2e, fma(tail, log2e, exponent));
}

/// 2^x for x <= 126; relative error <= 3e-7. Below -64 the result is 0, so that no denormal enters
/// the arithmetic (they cost several times the frame; the contribution is below 6e-20).
template <int W>
Pack<W> exp2(Pack<W> x) {
  const Pack<W> clamped = max(x, Pack<W>(-64.0f));
  // Rounds to nearest: the whole number stands in the low bits of the sum.
  const Pack<W> shifter(0x1.8p23f);
  const Pack<W> shifted = clamped + shifter;
  const Pack<W> f = clamped - (shifted - shifter);  // [-0.5, 0.5]
  Pack<W> p = Pack<W>(1.5403530394e-4f);
  p = fma(p, f, Pack<W>(1.3333558146e-3f));
  p = fma(p, f, Pack<W>(9.6181291076e-3f));
  p = fma(p, f, Pack<W>(5.5504108665e-2f));
  p = fma(p, f, Pack<W>(2.4022650696e-1f));
  p = fma(p, f, Pack<W>(6.9314718056e-1f));
  p = fma(p, f, Pack<W>(1.0f));
  const Pack<W> scale = from_bits<W>((bits_of(shifted) + 127) << 23);
  return select(x < Pack<W>(-64.0f), Pack<W>(0.0f), p * scale);
}

/// x^e for x in [0, 1 + 1e-6] and e = 0 or in [1e-30, 1e5], with 0^0 = 1. Results below 2^-64 are
/// 0. Relative error <= 1e-6 + 5e-7 e |log2 x|.
template <int W>
Pack<W> pow_unit(Pack<W> x, Pack<W> e) {
  const Pack<W> smallest(0x1p-126f);
  const Pack<W> log_of_zero(-0x1p120f);
  const Pack<W> log = select(x < smallest, log_of_zero, log2(max(x, smallest)));
  return exp2(e * log);
}

/// Writes colours of 16 lanes, `rgb` = 16 reds, 16 greens, 16 blues, as three floats a pixel: lane
/// i to out[offsets[pixels[i]]]. Lanes from `lanes` on are left out.
inline void scatter_rgb(const float* rgb, const unsigned char* pixels, int lanes,
                        const int* offsets, float* out) {
  using Four = Lanes<float, 4>::type;
  for (int first = 0; first < lanes; first += 4) {
    Four red;
    Four green;
    Four blue;
    __builtin_memcpy(&red, rgb + first, sizeof(red));
    __builtin_memcpy(&green, rgb + 16 + first, sizeof(green));
    __builtin_memcpy(&blue, rgb + 32 + first, sizeof(blue));
    const Four rg_low = __builtin_shufflevector(red, green, 0, 4, 1, 5);
    const Four rg_high = __builtin_shufflevector(red, green, 2, 6, 3, 7);
    const Four rgb_of[4] = {__builtin_shufflevector(rg_low, blue, 0, 1, 4, 4),
                            __builtin_shufflevector(rg_low, blue, 2, 3, 5, 5),
                            __builtin_shufflevector(rg_high, blue, 0, 1, 6, 6),
                            __builtin_shufflevector(rg_high, blue, 2, 3, 7, 7)};
    const int left = lanes - first;
    for (int i = 0; i < (left < 4 ? left : 4); ++i) {
      __builtin_memcpy(out + offsets[pixels[first + i]], &rgb_of[i], 3 * sizeof(float));
    }
  }
}

/// Three packs: a vector or a colour.
template <class F>
struct Vec3 {
  F x, y, z;
};
template <class F>
F dot(Vec3<F> a, Vec3<F> b) {
  return fma(a.x, b.x, fma(a.y, b.y, a.z * b.z));
}
template <class F>
Vec3<F> operator*(Vec3<F> a, F s) {
  return {a.x * s, a.y * s, a.z * s};
}

/// Three packs whose first floats lie `stride` floats apart.
template <int W>
Vec3<Pack<W>> load_vec3(const float* p, int stride) {
  return {Pack<W>::load(p), Pack<W>::load(p + stride), Pack<W>::load(p + 2 * stride)};
}
template <int W>
void store_vec3(Vec3<Pack<W>> v, float* p, int stride) {
  v.x.store(p);
  v.y.store(p + stride);
  v.z.store(p + 2 * stride);
}

}  // namespace relume::RELUME_ISA

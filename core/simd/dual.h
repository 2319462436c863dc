#pragma once

// Dual numbers over packs: forward-mode derivatives with respect to three parameters. Part of the
// kernel sources: see core/simd/pack.h for what may be called here.

#include "core/simd/pack.h"

namespace relume::RELUME_ISA {

/// A value and its three partial derivatives.
template <class P>
struct Dual {
  P value;
  P d0, d1, d2;

  Dual() = default;
  Dual(float x) : value(x), d0(0.0f), d1(0.0f), d2(0.0f) {}  // NOLINT: constants are implicit
  explicit Dual(P x) : value(x), d0(0.0f), d1(0.0f), d2(0.0f) {}
  Dual(P x, P a, P b, P c) : value(x), d0(a), d1(b), d2(c) {}
};

template <class P>
Dual<P> operator+(Dual<P> a, Dual<P> b) {
  return {a.value + b.value, a.d0 + b.d0, a.d1 + b.d1, a.d2 + b.d2};
}
template <class P>
Dual<P> operator-(Dual<P> a, Dual<P> b) {
  return {a.value - b.value, a.d0 - b.d0, a.d1 - b.d1, a.d2 - b.d2};
}
template <class P>
Dual<P> operator*(Dual<P> a, Dual<P> b) {
  return {a.value * b.value, fma(a.d0, b.value, a.value * b.d0), fma(a.d1, b.value, a.value * b.d1),
          fma(a.d2, b.value, a.value * b.d2)};
}
template <class P>
Dual<P> operator/(Dual<P> a, Dual<P> b) {
  const P inverse = P(1.0f) / b.value;
  const P ratio = a.value * inverse;
  return {ratio, (a.d0 - ratio * b.d0) * inverse, (a.d1 - ratio * b.d1) * inverse,
          (a.d2 - ratio * b.d2) * inverse};
}
template <class P>
Dual<P> fma(Dual<P> a, Dual<P> b, Dual<P> c) {
  return a * b + c;
}

/// a > b ? a : b; at a tie the derivative is b's.
template <class P>
Dual<P> max(Dual<P> a, Dual<P> b) {
  const auto mask = a.value > b.value;
  return {select(mask, a.value, b.value), select(mask, a.d0, b.d0), select(mask, a.d1, b.d1),
          select(mask, a.d2, b.d2)};
}

/// Square root; the derivative at 0 is taken as 0.
template <class P>
Dual<P> sqrt(Dual<P> a) {
  const P root = sqrt(a.value);
  const auto positive = root > P(1e-12f);
  const P slope = select(positive, P(0.5f) / max(root, P(1e-12f)), P(0.0f));
  return {root, a.d0 * slope, a.d1 * slope, a.d2 * slope};
}

/// As for packs.
template <class P>
Dual<P> rsqrt(Dual<P> a) {
  const P inverse = rsqrt(a.value);
  const P slope = P(-0.5f) * inverse * inverse * inverse;
  return {inverse, a.d0 * slope, a.d1 * slope, a.d2 * slope};
}

/// x^e as for packs; derivatives vanish where the power does.
template <class P>
Dual<P> pow_unit(Dual<P> x, Dual<P> e) {
  const P power = pow_unit(x.value, e.value);
  const P safe = max(x.value, P(1e-30f));
  const auto alive = power > P(0.0f);
  const P by_x = select(alive, power * e.value / safe, P(0.0f));
  const P by_e = select(alive, power * log2(safe) * P(0.69314718f), P(0.0f));
  return {power, fma(by_x, x.d0, by_e * e.d0), fma(by_x, x.d1, by_e * e.d1),
          fma(by_x, x.d2, by_e * e.d2)};
}

}  // namespace relume::RELUME_ISA

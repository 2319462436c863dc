#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace relume {

/// Factors the symmetric positive definite n x n matrix `a` (row-major) in place: its lower
/// triangle becomes L with a = L L^T. False when a pivot is not positive or not finite.
inline bool factor_cholesky(std::vector<double>& a, size_t n) {
  for (size_t j = 0; j < n; ++j) {
    double pivot = a[j * n + j];
    const double scale = pivot;
    for (size_t k = 0; k < j; ++k) pivot -= a[j * n + k] * a[j * n + k];
    if (!(pivot > 1e-14 * scale) || !std::isfinite(pivot)) return false;
    const double root = std::sqrt(pivot);
    a[j * n + j] = root;
    for (size_t i = j + 1; i < n; ++i) {
      double sum = a[i * n + j];
      for (size_t k = 0; k < j; ++k) sum -= a[i * n + k] * a[j * n + k];
      a[i * n + j] = sum / root;
    }
  }
  return true;
}

/// x <- L^-1 x for the n x columns matrix x.
inline void forward_substitute(const std::vector<double>& l, size_t n, std::vector<double>& x,
                               size_t columns) {
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < i; ++k) {
      const double factor = l[i * n + k];
      if (factor == 0) continue;
      for (size_t c = 0; c < columns; ++c) x[i * columns + c] -= factor * x[k * columns + c];
    }
    for (size_t c = 0; c < columns; ++c) x[i * columns + c] /= l[i * n + i];
  }
}

/// x <- L^-T x.
inline void backward_substitute(const std::vector<double>& l, size_t n, std::vector<double>& x,
                                size_t columns) {
  for (size_t i = n; i-- > 0;) {
    for (size_t k = i + 1; k < n; ++k) {
      const double factor = l[k * n + i];
      if (factor == 0) continue;
      for (size_t c = 0; c < columns; ++c) x[i * columns + c] -= factor * x[k * columns + c];
    }
    for (size_t c = 0; c < columns; ++c) x[i * columns + c] /= l[i * n + i];
  }
}

}  // namespace relume

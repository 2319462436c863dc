#pragma once

namespace relume {

/// out[i * out_stride + j] = sum over x < length of a[i * a_stride + x] * b[j * b_stride + x], for
/// i < a_rows and j < b_rows: the product A B^T of two small row-major matrices, on the best
/// instruction set of this machine. `length` must be a multiple of 16. The order of summation is
/// fixed for an instruction set. Thread-safe, no allocation.
void dot_products(const float* a, int a_rows, int a_stride, const float* b, int b_rows,
                  int b_stride, int length, float* out, int out_stride);

namespace scalar {
void dot_products(const float*, int, int, const float*, int, int, int, float*, int);
}
namespace sse42 {
void dot_products(const float*, int, int, const float*, int, int, int, float*, int);
}
namespace avx2 {
void dot_products(const float*, int, int, const float*, int, int, int, float*, int);
}
namespace avx512 {
void dot_products(const float*, int, int, const float*, int, int, int, float*, int);
}

}  // namespace relume

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"
#include "core/simd/dot_products.h"

namespace relume::test {
namespace {

/// Rows of random numbers in [-1, 1), each `stride` floats.
std::vector<float> random_rows(int rows, int stride, uint64_t index) {
  Random random(1, RandomStream::tests, index);
  std::vector<float> values(static_cast<size_t>(rows) * stride);
  for (float& value : values) value = random.uniform(-1, 1);
  return values;
}

TEST(DotProducts, EqualTheDoubleSumsForEveryShape) {
  for (const int length : {16, 48, 192}) {
    for (int b_rows = 1; b_rows <= 9; ++b_rows) {
      const int a_rows = 3;
      const int stride = length + 16;
      const std::vector<float> a = random_rows(a_rows, stride, 1);
      const std::vector<float> b = random_rows(b_rows, stride, 2);
      std::vector<float> out(static_cast<size_t>(a_rows) * (b_rows + 1), -7.0f);
      dot_products(a.data(), a_rows, stride, b.data(), b_rows, stride, length, out.data(),
                   b_rows + 1);
      for (int i = 0; i < a_rows; ++i) {
        for (int j = 0; j < b_rows; ++j) {
          double expected = 0;
          for (int x = 0; x < length; ++x) {
            expected += double{a[i * stride + x]} * b[j * stride + x];
          }
          ASSERT_NEAR(out[i * (b_rows + 1) + j], expected, 1e-5 * length)
              << "length " << length << " rows " << b_rows;
        }
        ASSERT_EQ(out[i * (b_rows + 1) + b_rows], -7.0f) << "wrote past the row";
      }
    }
  }
}

}  // namespace
}  // namespace relume::test

#include <gtest/gtest.h>

#include <limits>

#include "core/math/half.h"

namespace relume::test {
namespace {

/// The value of the finite, positive half float with these bits.
float half_value(uint32_t bits) {
  const auto exponent = static_cast<int>(bits >> 10);
  const auto mantissa = static_cast<float>(bits & 1023);
  if (exponent == 0) return std::ldexp(mantissa, -24);
  return std::ldexp(1 + mantissa / 1024, exponent - 15);
}

TEST(NearestHalf, KeepsEveryHalfAndRoundsMiddlesToEven) {
  constexpr uint32_t largest = 0x7bff;
  for (uint32_t bits = 0; bits <= largest; ++bits) {
    const float low = half_value(bits);
    EXPECT_EQ(nearest_half(low), low) << bits;
    EXPECT_EQ(nearest_half(-low), -low) << bits;
    if (bits == largest) break;
    const float high = half_value(bits + 1);
    const float middle = 0.5f * (low + high);
    EXPECT_EQ(nearest_half(middle), bits % 2 == 0 ? low : high) << bits;
    EXPECT_EQ(nearest_half(std::nextafter(middle, 0.0f)), low) << bits;
    EXPECT_EQ(nearest_half(std::nextafter(middle, 1e9f)), high) << bits;
  }
}

TEST(NearestHalf, EndsAtTheLargest) {
  EXPECT_EQ(nearest_half(65519), largest_half);
  EXPECT_EQ(nearest_half(1e30f), largest_half);
  EXPECT_EQ(nearest_half(-std::numeric_limits<float>::infinity()), -largest_half);
  EXPECT_TRUE(std::isnan(nearest_half(std::numeric_limits<float>::quiet_NaN())));
  EXPECT_EQ(nearest_half(1e-12f), 0);
}

}  // namespace
}  // namespace relume::test

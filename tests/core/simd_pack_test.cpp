#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/base/random.h"
#include "tests/core/simd_functions.h"

namespace relume {
namespace {

using test::SimdFunctions;

SimdFunctions functions_of(InstructionSet set) {
  switch (set) {
#if defined(RELUME_X86_KERNELS)
    case InstructionSet::sse42:
      return sse42::simd_functions();
    case InstructionSet::avx2:
      return avx2::simd_functions();
    case InstructionSet::avx512:
      return avx512::simd_functions();
#endif
    default:
      return scalar::simd_functions();
  }
}

constexpr int count = 1 << 16;

/// Floats spread evenly over [low, high], both ends included.
std::vector<float> spread(double low, double high) {
  std::vector<float> values(count);
  for (int i = 0; i < count; ++i) {
    values[i] = static_cast<float>(low + (high - low) * i / (count - 1));
  }
  return values;
}

/// 2^e for e spread evenly over [low, high].
std::vector<float> spread_powers(double low, double high) {
  std::vector<float> values(count);
  for (int i = 0; i < count; ++i) {
    values[i] = static_cast<float>(std::exp2(low + (high - low) * i / (count - 1)));
  }
  return values;
}

class Simd : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!is_supported(GetParam())) GTEST_SKIP() << "this machine or build lacks the set";
    simd_ = functions_of(GetParam());
  }
  std::vector<float> map(void (*function)(const float*, float*, int), const std::vector<float>& x) {
    std::vector<float> out(x.size());
    function(x.data(), out.data(), static_cast<int>(x.size()));
    return out;
  }
  std::vector<float> power(const std::vector<float>& x, const std::vector<float>& e) {
    std::vector<float> out(x.size());
    simd_.pow_unit(x.data(), e.data(), out.data(), static_cast<int>(x.size()));
    return out;
  }
  SimdFunctions simd_{};
};

void expect_log2_bound(const std::vector<float>& x, const std::vector<float>& y, double near_one) {
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = std::log2(static_cast<double>(x[i]));
    const double error = std::abs(y[i] - exact);
    ASSERT_LE(error, 2e-7 * std::max(1.0, std::abs(exact))) << "x " << x[i] << " got " << y[i];
    if (std::abs(x[i] - 1) < near_one) {
      ASSERT_LE(error, 4e-7 * std::abs(exact)) << "x " << x[i] << " got " << y[i];
    }
  }
}

TEST_P(Simd, Log2KeepsItsBound) {
  for (const auto& x : {spread_powers(-126, 127.99), spread(0.4, 2.5), spread(0.999, 1.001)}) {
    expect_log2_bound(x, map(simd_.log2, x), 0.05);
  }
  std::vector<float> smallest(16, 0x1p-126f);
  smallest[1] = std::numeric_limits<float>::max();
  smallest[2] = 1.0f;
  expect_log2_bound(smallest, map(simd_.log2, smallest), 0.05);
}

TEST_P(Simd, Exp2KeepsItsBound) {
  for (const auto& x : {spread(-64, 126), spread(-1, 1), spread(-0.5001, -0.4999)}) {
    const std::vector<float> y = map(simd_.exp2, x);
    for (size_t i = 0; i < x.size(); ++i) {
      const double exact = std::exp2(static_cast<double>(x[i]));
      ASSERT_LE(std::abs(y[i] - exact), 3e-7 * exact) << "x " << x[i];
    }
  }
}

TEST_P(Simd, Exp2IsZeroFarBelow) {
  std::vector<float> x = spread(-1e6, -64.01);
  x[0] = -std::numeric_limits<float>::infinity();
  x[1] = -std::numeric_limits<float>::max();
  for (const float y : map(simd_.exp2, x)) ASSERT_EQ(y, 0.0f);
}

TEST_P(Simd, PowUnitKeepsItsBound) {
  Random random(1, RandomStream::tests, 0);
  std::vector<float> x(count);
  std::vector<float> e(count);
  for (int i = 0; i < count; ++i) {
    const float closeness = random.uniform(-20, 0);
    x[i] = i % 3 == 0 ? random.uniform() : 1 - std::exp2(closeness);
    if (i % 17 == 0) x[i] = 1 + 1e-6f * random.uniform();
    const float decade = random.uniform(-3, 5);
    e[i] = i % 13 == 0 ? 0.0f : i % 11 == 0 ? 1e5f : std::pow(10.0f, decade);
  }
  const std::vector<float> y = power(x, e);
  for (int i = 0; i < count; ++i) {
    const double exact = std::pow(static_cast<double>(x[i]), static_cast<double>(e[i]));
    ASSERT_TRUE(std::isfinite(y[i]) && y[i] >= 0) << x[i] << " ^ " << e[i];
    if (exact < 0x1p-63) {
      ASSERT_LE(y[i], 0x1p-62) << x[i] << " ^ " << e[i];
      continue;
    }
    const double bound = 1e-6 + 5e-7 * e[i] * std::abs(std::log2(static_cast<double>(x[i])));
    ASSERT_LE(std::abs(y[i] - exact), bound * exact) << x[i] << " ^ " << e[i];
  }
}

TEST_P(Simd, PowUnitAtTheCorners) {
  const std::vector<float> x = {0, 0, 0, 1, 1, 1, 1e-40f, 0x1p-126f, 1, 1, 1, 1, 1, 1, 1, 1};
  const std::vector<float> e = {0, 1, 1e5f, 0, 1, 1e5f, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0};
  const std::vector<float> y = power(x, e);
  const std::vector<float> expected = {1, 0, 0, 1, 1, 1, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1};
  EXPECT_EQ(y, expected);
}

TEST_P(Simd, RsqrtKeepsItsBound) {
  const std::vector<float> x = spread_powers(-120, 120);
  const std::vector<float> y = map(simd_.rsqrt, x);
  for (size_t i = 0; i < x.size(); ++i) {
    const double exact = 1 / std::sqrt(static_cast<double>(x[i]));
    ASSERT_LE(std::abs(y[i] - exact), 4e-7 * exact) << "x " << x[i];
  }
}

TEST_P(Simd, SqrtIsExact) {
  std::vector<float> x = spread_powers(-126, 127.99);
  x[0] = 0;
  const std::vector<float> y = map(simd_.sqrt, x);
  for (size_t i = 0; i < x.size(); ++i) ASSERT_EQ(y[i], std::sqrt(x[i])) << "x " << x[i];
}

TEST_P(Simd, FmaRoundsOnceOrTwice) {
  const std::vector<float> a = spread(-3, 3);
  const std::vector<float> b = spread(5, -4);
  const std::vector<float> c = spread(-1, 1);
  std::vector<float> y(count);
  simd_.fma(a.data(), b.data(), c.data(), y.data(), count);
  for (int i = 0; i < count; ++i) {
    const float once = std::fma(a[i], b[i], c[i]);
    volatile float product = a[i] * b[i];
    const float twice = product + c[i];
    ASSERT_TRUE(y[i] == once || y[i] == twice) << a[i] << " * " << b[i] << " + " << c[i];
  }
}

TEST_P(Simd, MinAndMaxDropANanOfTheFirst) {
  std::vector<float> a(16, std::nanf(""));
  std::vector<float> b(16, 2.0f);
  a[1] = 1;
  a[2] = 3;
  std::vector<float> low(16);
  std::vector<float> high(16);
  simd_.minimum(a.data(), b.data(), low.data(), 16);
  simd_.maximum(a.data(), b.data(), high.data(), 16);
  EXPECT_EQ(low[0], 2);
  EXPECT_EQ(low[1], 1);
  EXPECT_EQ(low[2], 2);
  EXPECT_EQ(high[0], 2);
  EXPECT_EQ(high[1], 2);
  EXPECT_EQ(high[2], 3);
}

std::string set_name(const testing::TestParamInfo<InstructionSet>& info) {
  return info.param == InstructionSet::sse42
             ? "sse42"
             : std::string(label_of(instruction_set_labels, info.param));
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, Simd,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512),
                         set_name);

TEST(InstructionSetChoice, NeverChoosesWhatTheMachineLacks) {
  for (const Label<InstructionSet>& row : instruction_set_labels) {
    const InstructionSet chosen = choose_instruction_set(row.value);
    EXPECT_NE(chosen, InstructionSet::automatic);
    EXPECT_TRUE(is_supported(chosen)) << row.name;
    if (row.value != InstructionSet::automatic) {
      EXPECT_LE(static_cast<int>(chosen), static_cast<int>(row.value)) << row.name;
      if (is_supported(row.value)) {
        EXPECT_EQ(chosen, row.value);
      }
    }
  }
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

#include "core/base/random.h"

namespace relume {
namespace {

using Block = std::array<uint32_t, 4>;

// Known answers of Random123's kat_vectors for philox4x32 with 10 rounds.
TEST(Philox, MatchesThePublishedVectors) {
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  const uint32_t ones = 0xffffffff;
  EXPECT_EQ(philox({ones, ones, ones, ones}, {ones, ones}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
  EXPECT_EQ(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
            (Block{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, EqualTriplesGiveEqualSequences) {
  Random a(5, RandomStream::tests, 9);
  Random b(5, RandomStream::tests, 9);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.bits(), b.bits());
}

TEST(Random, AnyPartOfTheTripleChangesTheSequence) {
  std::set<uint32_t> first;
  for (const uint64_t seed : {uint64_t{0}, uint64_t{1}, uint64_t{1} << 32}) {
    for (const RandomStream stream : {RandomStream::pixel_samples, RandomStream::tests}) {
      for (const uint64_t index : {uint64_t{0}, uint64_t{1}, uint64_t{1} << 32}) {
        first.insert(Random(seed, stream, index).bits());
      }
    }
  }
  EXPECT_EQ(first.size(), 18u);
}

TEST(Random, UniformStaysBelowOne) {
  EXPECT_EQ(unit_float(0), 0.0f);
  EXPECT_LT(unit_float(0xffffffff), 1.0f);
  EXPECT_EQ(unit_float(0xffffffff), 1.0f - 0x1p-24f);
}

TEST(Random, UniformHasTheMomentsOfTheUniformDistribution) {
  Random random(3, RandomStream::tests, 0);
  const int n = 100000;
  double sum = 0;
  double squares = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform();
    sum += x;
    squares += x * x;
  }
  // Six standard errors: sigma(x) = 0.2887, sigma(x^2) = 0.2981.
  EXPECT_NEAR(sum / n, 0.5, 6 * 0.2887 / std::sqrt(n));
  EXPECT_NEAR(squares / n, 1.0 / 3, 6 * 0.2981 / std::sqrt(n));
}

TEST(Random, BelowIsEvenOverItsRange) {
  Random random(4, RandomStream::tests, 0);
  const int n = 70000;
  std::vector<int> counts(7);
  for (int i = 0; i < n; ++i) ++counts.at(random.below(7));
  double chi_squared = 0;
  for (const int count : counts) chi_squared += (count - 1e4) * (count - 1e4) / 1e4;
  EXPECT_LT(chi_squared, 35.0);  // 6 degrees of freedom: p < 5e-6
  EXPECT_EQ(random.below(1), 0u);
}

}  // namespace
}  // namespace relume

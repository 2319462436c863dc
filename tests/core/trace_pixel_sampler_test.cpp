#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/trace/pixel_sampler.h"

namespace relume {
namespace {

std::vector<vec2> positions_of(int spp, uint64_t seed, uint64_t pixel) {
  std::vector<vec2> positions;
  sample_pixel(make_pixel_strata(spp), seed, pixel, positions);
  return positions;
}

TEST(PixelStrata, HoldsAsManyCellsAsSamples) {
  for (int spp = 1; spp <= 4096; ++spp) {
    const PixelStrata strata = make_pixel_strata(spp);
    EXPECT_EQ(strata.spp, spp);
    ASSERT_EQ(std::accumulate(strata.columns.begin(), strata.columns.end(), 0), spp) << spp;
    const auto [least, most] = std::minmax_element(strata.columns.begin(), strata.columns.end());
    ASSERT_GE(*least, 1) << spp;
    ASSERT_LE(*most - *least, 1) << spp;
    // No cell is a sliver: width 1 / columns against height columns / spp.
    ASSERT_LE(spp, 3 * *least * *most) << spp;
    ASSERT_LE(*least * *most, 3 * spp) << spp;
  }
}

TEST(PixelStrata, UsesTheFullGridsThatTheReportNames) {
  EXPECT_EQ(make_pixel_strata(25).columns, (std::vector<int>{5, 5, 5, 5, 5}));
  EXPECT_EQ(make_pixel_strata(8).columns, (std::vector<int>{4, 4}));
  EXPECT_EQ(make_pixel_strata(4).columns, (std::vector<int>{2, 2}));
  EXPECT_EQ(make_pixel_strata(2).columns, (std::vector<int>{2}));
  EXPECT_EQ(make_pixel_strata(1).columns, (std::vector<int>{1}));
  EXPECT_EQ(make_pixel_strata(7).columns, (std::vector<int>{2, 2, 3}));
}

class PixelSampler : public testing::TestWithParam<int> {};

TEST_P(PixelSampler, PutsOneSampleIntoEachCellInScanlineOrder) {
  const int spp = GetParam();
  const PixelStrata strata = make_pixel_strata(spp);
  for (uint64_t pixel = 0; pixel < 20; ++pixel) {
    const std::vector<vec2> positions = positions_of(spp, 7, pixel);
    ASSERT_EQ(positions.size(), static_cast<size_t>(spp));
    size_t i = 0;
    double top = 0;
    for (const int columns : strata.columns) {
      const double height = static_cast<double>(columns) / spp;
      for (int column = 0; column < columns; ++column, ++i) {
        const vec2 p = positions[i];
        EXPECT_GE(p.x, static_cast<double>(column) / columns - 1e-6);
        EXPECT_LE(p.x, static_cast<double>(column + 1) / columns + 1e-6);
        EXPECT_GE(p.y, top - 1e-6);
        EXPECT_LE(p.y, top + height + 1e-6);
        EXPECT_GE(std::min(p.x, p.y), 0.0f);
        EXPECT_LT(std::max(p.x, p.y), 1.0f);
      }
      top += height;
    }
    EXPECT_NEAR(top, 1, 1e-12);
  }
}

TEST_P(PixelSampler, DependsOnSeedAndPixelAlone) {
  const int spp = GetParam();
  EXPECT_EQ(positions_of(spp, 1, 5), positions_of(spp, 1, 5));
  EXPECT_NE(positions_of(spp, 1, 5), positions_of(spp, 2, 5));
  EXPECT_NE(positions_of(spp, 1, 5), positions_of(spp, 1, 6));
}

TEST_P(PixelSampler, MeanIsThePixelCentre) {
  const int spp = GetParam();
  dvec2 sum(0);
  const int pixels = 4000;
  for (int pixel = 0; pixel < pixels; ++pixel) {
    for (const vec2 p : positions_of(spp, 3, static_cast<uint64_t>(pixel))) sum += dvec2(p);
  }
  const dvec2 mean = sum / (static_cast<double>(pixels) * spp);
  // The standard deviation of one uniform number is 0.289; strata only lower it. Six sigma.
  const double bound = 6 * 0.289 / std::sqrt(static_cast<double>(pixels) * spp);
  EXPECT_NEAR(mean.x, 0.5, bound);
  EXPECT_NEAR(mean.y, 0.5, bound);
}

INSTANTIATE_TEST_SUITE_P(SamplesPerPixel, PixelSampler,
                         testing::Values(1, 2, 3, 5, 7, 8, 13, 16, 25, 31, 64, 97, 100));

TEST(PixelSampler, AppendsToWhatIsThere) {
  std::vector<vec2> positions = {vec2(9)};
  sample_pixel(make_pixel_strata(4), 1, 1, positions);
  ASSERT_EQ(positions.size(), 5u);
  EXPECT_EQ(positions[0], vec2(9));
}

}  // namespace
}  // namespace relume

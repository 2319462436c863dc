// Visibility as a distribution: what rays give is right on average, what `coverage` gives is not,
// and by how much.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "shadow/coverage.h"
#include "shadow/members.h"
#include "tests/support/merged_cache.h"
#include "tests/support/pixel_statistics.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

constexpr double level = 0.01;

/// Strands above a floor that fills the picture.
Scene make_strand_scene() {
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0.2f, 0}, 30), 12, 12);
  const uint32_t floor = add_material(scene, "lambert");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_quad(vec3(0), {0, 0, 8}, {8, 0, 0}, floor));
  for (int i = 0; i < 40; ++i) {
    const float x = -1 + 0.05f * static_cast<float>(i);
    add_shape(scene, make_strand({x, 0, 0}, {x + 0.1f, 0.9f, 0.1f}, 0.008f, 4, hair));
  }
  return scene;
}

const Light& light() {
  static const Light above = make_point_light({1, 3, 2});
  return above;
}

/// As means of 3 x 3 pixels: single ones that a few trials darken are far from normal.
std::vector<double> block_means(const std::vector<double>& pixels, double factor) {
  constexpr size_t side = 12;
  std::vector<double> blocks(pixels.size() / 9);
  for (size_t i = 0; i < pixels.size(); ++i) {
    blocks[i / side / 3 * (side / 3) + i % side / 3] += factor / 9 * pixels[i];
  }
  return blocks;
}

class VisibilityStatistics : public testing::Test {
 protected:
  /// Visibility of pixels from all samples, one ray each.
  std::vector<double> of_samples(int spp, uint64_t seed) const {
    const RelightCache all = make_full_cache(scene_, tracer_, spp, seed);
    MemberVisibility rays(tracer_, all, 1);
    return pixel_visibility(all, rays, light());
  }
  PixelMoments samples_moments(int spp, int trials, double factor = 1) const {
    PixelMoments moments;
    for (int trial = 0; trial < trials; ++trial) {
      moments.add(block_means(of_samples(spp, static_cast<uint64_t>(1000 * spp + trial)), factor));
    }
    return moments;
  }
  /// Of one record a pixel and type, by all of its members.
  PixelMoments members_moments(int spp, int trials, double factor = 1) const {
    PixelMoments moments;
    for (int trial = 0; trial < trials; ++trial) {
      const RelightCache merged = make_merged_cache(scene_, tracer_, spp, max_members,
                                                    static_cast<uint64_t>(1000 * spp + trial));
      MemberVisibility members(tracer_, merged, max_members);
      moments.add(block_means(pixel_visibility(merged, members, light()), factor));
    }
    return moments;
  }

  Scene scene_ = make_strand_scene();
  Tracer tracer_{scene_};
  PixelMoments truth_ = samples_moments(144, 24);
};

TEST_F(VisibilityStatistics, ARayFromEachSampleIsUnbiased) {
  EXPECT_GT(p_of_difference(samples_moments(1, 300), truth_), level);
  EXPECT_GT(p_of_difference(samples_moments(4, 150), truth_), level);
  EXPECT_LT(p_of_difference(samples_moments(4, 150, 0.985), truth_), level) << "1.5 % is found";
}

TEST_F(VisibilityStatistics, RaysFromAllMembersAreUnbiased) {
  EXPECT_GT(p_of_difference(members_moments(4, 150), truth_), level);
  EXPECT_GT(p_of_difference(members_moments(9, 60), truth_), level);
  EXPECT_LT(p_of_difference(members_moments(4, 150, 0.985), truth_), level) << "1.5 % is found";
}

/// Its bias map has a bound: the mean over the picture, and that of the worst 3 x 3 pixels.
TEST_F(VisibilityStatistics, CoverageHasASmallBias) {
  PixelMoments coverage;
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const RelightCache merged = make_merged_cache(scene_, tracer_, 16, max_members, seed);
    CoverageVisibility source(tracer_, merged);
    coverage.add(block_means(pixel_visibility(merged, source, light()), 1));
  }
  double sum = 0;
  double worst = 0;
  for (size_t i = 0; i < coverage.pixels(); ++i) {
    const double bias = coverage.mean(i) - truth_.mean(i);
    sum += bias;
    worst = std::max(worst, std::abs(bias));
  }
  const double mean = sum / static_cast<double>(coverage.pixels());
  RecordProperty("mean_bias", fmt::format("{:.5f}", mean));
  RecordProperty("worst_bias", fmt::format("{:.5f}", worst));
  EXPECT_LT(std::abs(mean), 0.01);
  EXPECT_LT(worst, 0.03);
  EXPECT_LT(p_of_difference(coverage, truth_), level) << "it is a bias, not noise";
}

}  // namespace
}  // namespace relume

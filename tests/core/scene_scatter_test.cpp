#include <gtest/gtest.h>

#include "core/scene/io/scatter.h"

namespace relume {
namespace {

ScatterParams field() {
  ScatterParams params;
  params.count = 500;
  params.kinds = 3;
  params.low = {-50, 10};
  params.high = {50, 30};
  params.height = 2;
  params.scale_low = 0.5f;
  params.scale_high = 1.5f;
  return params;
}

TEST(Scatter, StaysInsideItsRanges) {
  const ScatterParams params = field();
  std::array<int, 3> kinds{};
  for (const Placement& p : scatter(params)) {
    const vec3 origin = p.world_from_local[3];
    EXPECT_GE(origin.x, params.low.x);
    EXPECT_LE(origin.x, params.high.x);
    EXPECT_EQ(origin.y, params.height);
    EXPECT_GE(origin.z, params.low.y);
    EXPECT_LE(origin.z, params.high.y);
    const float scale = uniform_scale(p.world_from_local);
    EXPECT_GT(scale, params.scale_low * 0.999f);
    EXPECT_LT(scale, params.scale_high * 1.001f);
    // Turned about y only: up stays up.
    EXPECT_NEAR(p.world_from_local[1].y, scale, 1e-4f);
    ++kinds.at(p.kind);
  }
  for (const int count : kinds) EXPECT_GT(count, 120);
}

TEST(Scatter, KeepsTheMinimumDistance) {
  ScatterParams params = field();
  params.min_distance = 1.1f;
  const std::vector<Placement> placements = scatter(params);
  ASSERT_EQ(placements.size(), params.count);
  for (size_t i = 0; i < placements.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const vec3 between = placements[i].world_from_local[3] - placements[j].world_from_local[3];
      EXPECT_GE(glm::length(between), params.min_distance) << i << " " << j;
    }
  }
}

TEST(Scatter, GivesUpWhenTheAreaIsFull) {
  ScatterParams params = field();
  params.min_distance = 20;
  const size_t count = scatter(params).size();
  EXPECT_GE(count, 5u);
  EXPECT_LT(count, 30u);
}

TEST(Scatter, DoesNotMoveEarlierPlacementsWhenTheCountGrows) {
  ScatterParams params = field();
  params.min_distance = 1;
  const std::vector<Placement> more = scatter(params);
  params.count = 100;
  const std::vector<Placement> fewer = scatter(params);
  ASSERT_EQ(fewer.size(), 100u);
  for (size_t i = 0; i < fewer.size(); ++i) {
    EXPECT_EQ(fewer[i].world_from_local, more[i].world_from_local);
  }
}

}  // namespace
}  // namespace relume

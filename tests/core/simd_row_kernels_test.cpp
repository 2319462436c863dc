#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/base/random.h"
#include "core/simd/row_kernels.h"

namespace relume::test {
namespace {

std::vector<float> random_values(int count, uint64_t index) {
  Random random(1, RandomStream::tests, index);
  std::vector<float> values(static_cast<size_t>(count));
  for (float& value : values) value = random.uniform(-1, 1);
  return values;
}

/// Rows as columns, their distances from each other, and what the kernels make of them.
struct Case {
  int rows;
  int dimensions;
  int stride;
  std::vector<float> points;   ///< rows x dimensions
  std::vector<float> columns;  ///< dimensions x stride

  Case(int row_count, int dimension_count)
      : rows(row_count),
        dimensions(dimension_count),
        stride((row_count + row_lanes - 1) / row_lanes * row_lanes),
        points(random_values(row_count * dimension_count, 3)),
        columns(static_cast<size_t>(stride) * dimension_count, 0.0f) {
    for (int row = 0; row < rows; ++row) {
      for (int i = 0; i < dimensions; ++i) columns[i * stride + row] = points[row * dimensions + i];
    }
  }

  double distance(int a, int b) const {
    double sum = 0;
    for (int i = 0; i < dimensions; ++i) {
      const double d = double{points[a * dimensions + i]} - points[b * dimensions + i];
      sum += d * d;
    }
    return sum;
  }

  std::vector<float> pairs(const RowKernels& kernels) const {
    std::vector<float> out(static_cast<size_t>(rows) * stride);
    kernels.distances(columns.data(), dimensions, stride, points.data(), rows, out.data());
    return out;
  }
};

class RowKernelsOf : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!is_supported(GetParam())) GTEST_SKIP() << "this machine or build lacks the set";
    kernels_ = row_kernels(GetParam());
  }
  RowKernels kernels_{};
};

TEST_P(RowKernelsOf, DistancesEqualTheDoubleSums) {
  for (int rows = 1; rows <= 35; ++rows) {
    const Case data(rows, 13);
    const std::vector<float> pairs = data.pairs(kernels_);
    for (int a = 0; a < rows; ++a) {
      for (int b = 0; b < rows; ++b) {
        ASSERT_NEAR(pairs[a * data.stride + b], data.distance(a, b), 1e-5) << a << " of " << rows;
        ASSERT_EQ(pairs[a * data.stride + b], pairs[b * data.stride + a]) << "not symmetric";
      }
      ASSERT_EQ(pairs[a * data.stride + a], 0.0f);
    }
  }
}

TEST_P(RowKernelsOf, NearestTakesTheLowerOfEquals) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  // Point by point, 16 rows.
  std::vector<float> distances(3 * row_lanes, 5.0f);
  distances[1] = 7;                  // row 1: points 1 and 2 are equal, and less
  distances[2 * row_lanes + 2] = 4;  // row 2: point 2
  distances[3] = nan;                // row 3: not point 0
  std::vector<int> nearest(row_lanes, -1);
  kernels_.nearest(distances.data(), 3, row_lanes, nearest.data());
  EXPECT_EQ(nearest[0], 0);
  EXPECT_EQ(nearest[1], 1);
  EXPECT_EQ(nearest[2], 2);
  EXPECT_EQ(nearest[3], 1);
}

TEST_P(RowKernelsOf, CentroidDistancesFollowFromPairs) {
  const Case data(25, 13);
  const std::vector<float> pairs = data.pairs(kernels_);
  const std::vector<int> members{3, 4, 11, 20, 24};
  std::vector<double> centroid(13, 0.0);
  for (const int m : members) {
    for (int i = 0; i < 13; ++i) centroid[i] += data.points[m * 13 + i] / 5.0;
  }
  std::vector<float> distances(data.stride);
  const float variance =
      kernels_.centroid_distances(pairs.data(), data.stride, members.data(), 5, distances.data());
  double expected_variance = 0;
  for (int row = 0; row < 25; ++row) {
    double expected = 0;
    for (int i = 0; i < 13; ++i) {
      const double d = data.points[row * 13 + i] - centroid[i];
      expected += d * d;
    }
    ASSERT_NEAR(distances[row], expected, 1e-5) << "row " << row;
    for (const int m : members) expected_variance += m == row ? expected / 5 : 0;
  }
  EXPECT_NEAR(variance, expected_variance, 1e-5);
  const int lone = 7;
  EXPECT_EQ(kernels_.centroid_distances(pairs.data(), data.stride, &lone, 1, distances.data()), 0);
  for (int row = 0; row < 25; ++row) ASSERT_EQ(distances[row], pairs[lone * data.stride + row]);
}

TEST_P(RowKernelsOf, LowerKeepsTheLeastAndSumsLanes) {
  const int stride = 2 * row_lanes;
  std::vector<float> least(stride, std::numeric_limits<float>::infinity());
  std::vector<float> distances(stride);
  for (int row = 0; row < stride; ++row) distances[row] = static_cast<float>(row);
  std::vector<float> sums(row_lanes);
  kernels_.lower(distances.data(), stride, least.data(), sums.data());
  EXPECT_EQ(least, distances);
  distances.assign(stride, 5.0f);
  distances[3] = std::numeric_limits<float>::quiet_NaN();
  kernels_.lower(distances.data(), stride, least.data(), sums.data());
  for (int row = 0; row < stride; ++row) {
    ASSERT_EQ(least[row], static_cast<float>(std::min(row, 5))) << row;
  }
  for (int lane = 0; lane < row_lanes; ++lane) {
    ASSERT_EQ(sums[lane], static_cast<float>(std::min(lane, 5) + 5)) << lane;
  }
}

TEST_P(RowKernelsOf, AgreeBitByBitWithScalar) {
  const RowKernels scalar = row_kernels(InstructionSet::scalar);
  for (const int rows : {1, 7, 16, 25, 64}) {
    const Case data(rows, 29);
    const std::vector<float> pairs = data.pairs(scalar);
    ASSERT_EQ(data.pairs(kernels_), pairs) << rows;
    std::vector<int> members;
    for (int row = 0; row < rows; row += 2) members.push_back(row);
    std::vector<float> a(data.stride), b(data.stride), a_sums(row_lanes), b_sums(row_lanes);
    const auto count = static_cast<int>(members.size());
    ASSERT_EQ(
        scalar.centroid_distances(pairs.data(), data.stride, members.data(), count, a.data()),
        kernels_.centroid_distances(pairs.data(), data.stride, members.data(), count, b.data()));
    ASSERT_EQ(a, b) << rows;
    scalar.lower(pairs.data(), data.stride, a.data(), a_sums.data());
    kernels_.lower(pairs.data(), data.stride, b.data(), b_sums.data());
    ASSERT_EQ(a, b) << rows;
    ASSERT_EQ(a_sums, b_sums) << rows;
    std::vector<int> a_nearest(data.stride), b_nearest(data.stride);
    scalar.nearest(pairs.data(), rows, data.stride, a_nearest.data());
    kernels_.nearest(pairs.data(), rows, data.stride, b_nearest.data());
    ASSERT_EQ(a_nearest, b_nearest) << rows;
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, RowKernelsOf,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512));

}  // namespace
}  // namespace relume::test

#include <gtest/gtest.h>

#include "core/shade/shader_list.h"
#include "reduction/features.h"
#include "reduction/merge.h"
#include "tests/support/records.h"

namespace relume {
namespace {

constexpr int width = 14;  // phong and kajiya-kay

struct Rows {
  SampleType type;
  std::vector<float> values;

  SampleMatrix matrix() const {
    return {&type, values.data(), static_cast<int>(values.size()) / type.width};
  }
};

Rows phong_rows(int count, uint64_t seed) {
  Rows rows{make_sample_type(Phong::info), {}};
  Random random(seed, RandomStream::tests, 0);
  for (int i = 0; i < count; ++i) test::append_random_vector(rows.type, random, rows.values);
  return rows;
}

TEST(Merge, AveragesAndRepresentsByCategory) {
  Rows rows = phong_rows(4, 1);
  const Clustering clustering{{0, 1, 0, 0}, {2, 1}};
  TypedRows out;
  merge_clusters(rows.matrix(), clustering, 0.1f, out);
  ASSERT_EQ(out.rows(), 2u);
  EXPECT_FLOAT_EQ(out.weights[0], 0.3f);
  EXPECT_FLOAT_EQ(out.weights[1], 0.1f);
  const float* v = out.values.data();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(v[i], rows.values[2 * width + i]) << "position and bias";
  dvec3 normal(0);
  for (const int row : {0, 2, 3}) {
    for (size_t c = 0; c < 3; ++c) normal[c] += rows.values[row * width + 4 + c];
  }
  normal = glm::normalize(normal);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[4 + c], normal[c], 1e-6);
  for (int i = 7; i < width; ++i) {
    const double mean =
        (double{rows.values[i]} + rows.values[2 * width + i] + rows.values[3 * width + i]) / 3;
    EXPECT_NEAR(v[i], mean, 1e-6 * (1 + mean)) << "float " << i;
  }
  for (int i = 0; i < width; ++i) {
    EXPECT_NEAR(v[width + i], rows.values[width + i], 1e-6f * (1 + std::abs(v[width + i])));
  }
}

TEST(Merge, ArtistsChoiceChangesTheCategory) {
  Rows rows = phong_rows(3, 2);
  rows.type.merges[0] = Merge::average;         // position
  rows.type.merges[3] = Merge::representative;  // diffuse
  TypedRows out;
  merge_clusters(rows.matrix(), {{0, 0, 0}, {1}}, 1.0f / 3, out);
  EXPECT_NEAR(out.values[0], (rows.values[0] + rows.values[width] + rows.values[2 * width]) / 3,
              1e-6);
  for (int i = 7; i < 10; ++i) EXPECT_EQ(out.values[i], rows.values[width + i]);
}

TEST(Merge, UnitDirectionsStayUnit) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const Rows rows = phong_rows(7, seed);
    TypedRows out;
    merge_clusters(rows.matrix(), {{0, 0, 1, 1, 1, 0, 1}, {0, 2}}, 0.1f, out);
    for (size_t row = 0; row < 2; ++row) {
      const float* n = &out.values[row * width + 4];
      EXPECT_NEAR(glm::length(vec3(n[0], n[1], n[2])), 1, 1e-6);
    }
  }
}

TEST(Merge, OppositeDirectionsKeepTheRepresentatives) {
  Rows rows = phong_rows(2, 3);
  for (int c = 0; c < 3; ++c) rows.values[width + 4 + c] = -rows.values[4 + c];
  TypedRows out;
  merge_clusters(rows.matrix(), {{0, 0}, {1}}, 0.5f, out);
  for (int c = 4; c < 7; ++c) EXPECT_EQ(out.values[c], rows.values[width + c]);
}

TEST(Merge, AxesOfOppositeSignAddUp) {
  Rows rows{make_sample_type(KajiyaKay::info), {}};
  Random random(4, RandomStream::tests, 0);
  for (int i = 0; i < 4; ++i) test::append_random_vector(rows.type, random, rows.values);
  const vec3 axes[] = {{0.6f, 0, 0.8f}, {0, -0.6f, -0.8f}, {0.8f, 0, 0.6f}, {0, -0.8f, -0.6f}};
  for (size_t row = 0; row < 4; ++row) {
    for (size_t c = 0; c < 3; ++c) rows.values[row * width + 4 + c] = axes[row][c];
  }
  TypedRows out;
  merge_clusters(rows.matrix(), {{0, 0, 0, 0}, {1}}, 0.25f, out);
  const vec3 expected = glm::normalize(axes[1] + axes[3] - axes[0] - axes[2]);
  for (size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(out.values[4 + c], expected[c], 1e-6) << "row 1's side";
}

TEST(CopyRows, KeepsEverything) {
  const Rows rows = phong_rows(5, 6);
  TypedRows out;
  copy_rows(rows.matrix(), 0.04f, out);
  EXPECT_EQ(out.values, rows.values);
  EXPECT_EQ(out.weights, std::vector<float>(5, 0.04f));
}

TEST(RawFeatures, AreTheFieldsWithoutTheBias) {
  const Rows rows = phong_rows(6, 7);
  Features features;
  make_raw_features(rows.matrix(), features);
  EXPECT_EQ(features.rows, 6);
  EXPECT_EQ(features.dimensions, width - 1);
  for (int i = 1; i < 6; ++i) {
    for (int j = 0; j < width; ++j) {
      if (j == 3) continue;
      const int feature = j < 3 ? j : j - 1;
      const float expected = rows.values[i * width + j] - rows.values[j];
      EXPECT_NEAR(features.row(i)[feature] - features.row(0)[feature], expected,
                  1e-6f * (1 + 1e5f * static_cast<float>(j == 13)));
    }
  }
}

TEST(RawFeatures, KeepTheirPrecisionFarAway) {
  Rows near = phong_rows(8, 8);
  for (float& value : near.values) value = std::round(value * 64) / 64;  // exact after the shift
  Rows far = near;
  for (int row = 0; row < 8; ++row) far.values[row * width] += 65536;
  Features a;
  Features b;
  make_raw_features(near.matrix(), a);
  make_raw_features(far.matrix(), b);
  for (size_t i = 0; i < a.values.size(); ++i) EXPECT_NEAR(a.values[i], b.values[i], 1e-6f);
}

class ScaledFeatures : public testing::TestWithParam<float> {};

TEST_P(ScaledFeatures, DoNotDependOnUnits) {
  const float scale = GetParam();
  Rows rows = phong_rows(9, 9);
  Features features;
  make_scaled_features(rows.matrix(), 1.5f, features);
  for (int row = 0; row < 9; ++row) {
    for (int c = 0; c < 4; ++c) rows.values[row * width + c] *= scale;
  }
  Features scaled;
  make_scaled_features(rows.matrix(), 1.5f * scale, scaled);
  for (size_t i = 0; i < features.values.size(); ++i) {
    EXPECT_NEAR(features.values[i], scaled.values[i], 1e-6f) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Units, ScaledFeatures, testing::Values(1e-6f, 1e-3f, 1e3f, 1e6f));

TEST(ScaledFeatures, TurnAxesToOneSide) {
  Rows rows{make_sample_type(KajiyaKay::info), {}};
  Random random(4, RandomStream::tests, 0);
  test::append_random_vector(rows.type, random, rows.values);
  rows.values.insert(rows.values.end(), rows.values.begin(), rows.values.begin() + width);
  for (int c = 4; c < 7; ++c) rows.values[width + c] = -rows.values[c];
  Features features;
  make_scaled_features(rows.matrix(), 1, features);
  for (int i = 0; i < features.dimensions; ++i) {
    EXPECT_FLOAT_EQ(features.row(0)[i], features.row(1)[i]) << i;
  }
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>

#include "core/shade/shader_list.h"
#include "reduction/merge.h"
#include "reduction/methods/cmeans.h"
#include "reduction/methods/kmeans.h"
#include "tests/support/records.h"

namespace relume {
namespace {

Features make_features(std::vector<float> values, int dimensions) {
  Features features;
  features.dimensions = dimensions;
  features.rows = static_cast<int>(values.size()) / dimensions;
  features.values = std::move(values);
  return features;
}

Features random_features(int rows, int dimensions, uint64_t seed) {
  Random random(seed, RandomStream::tests, 0);
  std::vector<float> values;
  for (int i = 0; i < rows * dimensions; ++i) values.push_back(random.uniform());
  return make_features(std::move(values), dimensions);
}

FuzzyClustering run(const Features& features, int k, int iterations = 200) {
  Random random(9, RandomStream::reduction, 1);
  return cmeans(features, k, 4, iterations, random);
}

void expect_sound(const FuzzyClustering& clustering, int rows) {
  ASSERT_EQ(clustering.memberships.size(), static_cast<size_t>(rows) * clustering.count());
  for (int row = 0; row < rows; ++row) {
    double sum = 0;
    for (int c = 0; c < clustering.count(); ++c) {
      const float u = clustering.memberships[static_cast<size_t>(row) * clustering.count() + c];
      ASSERT_GE(u, 0);
      sum += u;
    }
    ASSERT_NEAR(sum, 1, 1e-6) << "row " << row;
  }
}

TEST(Cmeans, MembershipsFulfilBezdeksEquations) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Features features = random_features(25, 3, seed);
    const FuzzyClustering clustering = run(features, 4, 2000);
    expect_sound(clustering, 25);
    ASSERT_EQ(clustering.count(), 4);
    // Centroids from memberships, memberships from centroids: a fixed point, to the settled 1e-3.
    std::vector<dvec3> centroids;
    for (int c = 0; c < 4; ++c) {
      dvec3 sum(0);
      double total = 0;
      for (int row = 0; row < 25; ++row) {
        const double weight =
            std::pow(double{clustering.memberships[row * 4 + c]}, cmeans_fuzziness);
        const float* v = features.row(row);
        sum += weight * dvec3(v[0], v[1], v[2]);
        total += weight;
      }
      centroids.push_back(sum / total);
    }
    for (int row = 0; row < 25; ++row) {
      const float* v = features.row(row);
      const dvec3 p(v[0], v[1], v[2]);
      for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (int h = 0; h < 4; ++h) {
          sum += std::pow(glm::distance(p, centroids[c]) / glm::distance(p, centroids[h]),
                          2 / (cmeans_fuzziness - 1));
        }
        ASSERT_NEAR(clustering.memberships[row * 4 + c], 1 / sum, 1e-2) << "seed " << seed;
      }
    }
  }
}

TEST(Cmeans, SharesRowsBetweenClusters) {
  // 5 lies halfway between two groups.
  const Features features = make_features({0, 1, 9, 10, 5}, 1);
  const FuzzyClustering clustering = run(features, 2);
  ASSERT_EQ(clustering.count(), 2);
  EXPECT_NEAR(clustering.memberships[8], 0.5, 1e-2);
  EXPECT_NEAR(std::abs(clustering.memberships[0] - clustering.memberships[6]), 1, 1e-2);
}

TEST(Cmeans, ZeroDistancesBelongToTheirCentroidAlone) {
  // Both centroids settle on their rows: distances of exactly zero.
  const Features features = make_features({0, 0, 0, 8, 8}, 1);
  const FuzzyClustering clustering = run(features, 2);
  ASSERT_EQ(clustering.count(), 2);
  for (int row = 0; row < 5; ++row) {
    EXPECT_EQ(clustering.memberships[row * 2] + clustering.memberships[row * 2 + 1], 1);
    EXPECT_EQ(clustering.memberships[row * 2] * clustering.memberships[row * 2 + 1], 0);
  }
}

TEST(Cmeans, EqualRowsAreOneClusterAndFewValuesAreFew) {
  for (const float value : {0.0f, 2.0f, 1e6f}) {
    const FuzzyClustering clustering = run(make_features(std::vector<float>(24, value), 3), 4);
    EXPECT_EQ(clustering.count(), 1);
    EXPECT_EQ(clustering.memberships, std::vector<float>(8, 1.0f));
  }
  EXPECT_LE(run(make_features({5, 7, 5, 7, 5, 9, 5}, 1), 6).count(), 3);
  EXPECT_EQ(run(make_features({5}, 1), 1).count(), 1);
}

TEST(Cmeans, HugeAndTinyDistancesStayFinite) {
  for (const float scale : {1e-15f, 1.0f, 1e15f}) {
    Features features = random_features(25, 6, 2);
    for (float& value : features.values) value *= scale;
    for (const int k : {1, 3, 24}) expect_sound(run(features, k), 25);
  }
}

TEST(Cmeans, RepresentativesAreOfTheHardCut) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const FuzzyClustering clustering = run(random_features(25, 5, seed), 6);
    for (int c = 0; c < clustering.count(); ++c) {
      const float* u = &clustering.memberships[static_cast<size_t>(clustering.representatives[c]) *
                                               clustering.count()];
      EXPECT_EQ(std::max_element(u, u + clustering.count()) - u, c);
    }
  }
}

TEST(MergeFuzzy, WeightsAndMeansFollowTheMemberships) {
  const SampleType type = make_sample_type(Lambert::info);
  std::vector<float> values;
  Random random(4, RandomStream::tests, 0);
  for (int i = 0; i < 3; ++i) test::append_random_vector(type, random, values);
  const SampleMatrix samples{&type, values.data(), 3};
  const FuzzyClustering clustering{{0.75f, 0.25f, 0.5f, 0.5f, 0, 1}, {0, 2}};
  TypedRows out;
  merge_fuzzy_clusters(samples, clustering, 0.2f, out);
  ASSERT_EQ(out.rows(), 2u);
  EXPECT_FLOAT_EQ(out.weights[0], 0.25f);
  EXPECT_FLOAT_EQ(out.weights[1], 0.35f);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(out.values[i], samples.row(0)[i]) << "position and bias of the representative";
    EXPECT_EQ(out.values[type.width + i], samples.row(2)[i]);
  }
  for (int i = 0; i < 3; ++i) {
    const int at = 7 + i;
    EXPECT_FLOAT_EQ(out.values[at],
                    (0.75f * samples.row(0)[at] + 0.5f * samples.row(1)[at]) / 1.25f);
    // The pixel's mean colour is kept exactly: weights times means sum to the samples' sum.
    const double kept =
        out.weights[0] * out.values[at] + out.weights[1] * out.values[type.width + at];
    EXPECT_NEAR(kept, 0.2 * (samples.row(0)[at] + samples.row(1)[at] + samples.row(2)[at]), 1e-6);
  }
}

TEST(MergeFuzzy, EqualsTheHardMergeForHardMemberships) {
  const SampleType type = make_sample_type(KajiyaKay::info);
  std::vector<float> values;
  Random random(8, RandomStream::tests, 0);
  for (int i = 0; i < 12; ++i) test::append_random_vector(type, random, values);
  const SampleMatrix samples{&type, values.data(), 12};
  Clustering hard{{}, {0, 1, 2}};
  FuzzyClustering fuzzy{{}, {0, 1, 2}};
  for (int row = 0; row < 12; ++row) {
    hard.cluster_of.push_back(row % 3);
    for (int c = 0; c < 3; ++c) fuzzy.memberships.push_back(c == row % 3 ? 1.0f : 0.0f);
  }
  TypedRows a;
  TypedRows b;
  merge_clusters(samples, hard, 0.04f, a);
  merge_fuzzy_clusters(samples, fuzzy, 0.04f, b);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.weights, b.weights);
}

}  // namespace
}  // namespace relume

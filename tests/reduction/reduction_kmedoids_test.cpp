#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "core/base/random.h"
#include "reduction/methods/kmeans.h"
#include "reduction/methods/kmedoids.h"

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

double squared_distance(const Features& features, int a, int b) {
  double sum = 0;
  for (int i = 0; i < features.dimensions; ++i) {
    const double d = double{features.row(a)[i]} - features.row(b)[i];
    sum += d * d;
  }
  return sum;
}

/// The sum that is minimised.
double cost(const Features& features, const std::vector<int>& medoids) {
  double sum = 0;
  for (int row = 0; row < features.rows; ++row) {
    double least = std::numeric_limits<double>::infinity();
    for (const int m : medoids) least = std::min(least, squared_distance(features, row, m));
    sum += least;
  }
  return sum;
}

/// The least cost of any `k` medoids, by trying all.
double least_cost(const Features& features, int k, int first, std::vector<int>& medoids) {
  if (static_cast<int>(medoids.size()) == k) return cost(features, medoids);
  double least = std::numeric_limits<double>::infinity();
  for (int row = first; row < features.rows; ++row) {
    medoids.push_back(row);
    least = std::min(least, least_cost(features, k, row + 1, medoids));
    medoids.pop_back();
  }
  return least;
}

TEST(Kmedoids, FindsObviousGroups) {
  const Features features = make_features({0, 10, 1, 11, 2, 12}, 1);
  const Clustering clustering = kmedoids(features, 2, 100);
  EXPECT_EQ(std::set<int>(clustering.representatives.begin(), clustering.representatives.end()),
            (std::set<int>{2, 3}));
  for (const int row : {0, 2, 4}) EXPECT_EQ(clustering.cluster_of[row], clustering.cluster_of[0]);
  for (const int row : {1, 3, 5}) EXPECT_EQ(clustering.cluster_of[row], clustering.cluster_of[1]);
}

TEST(Kmedoids, EveryRowIsInTheClusterOfItsNearestMedoid) {
  for (uint64_t seed = 0; seed < 30; ++seed) {
    const Features features = random_features(25, 13, seed);
    for (const int k : {1, 2, 5, 24, 25}) {
      const Clustering clustering = kmedoids(features, k, 100);
      ASSERT_EQ(clustering.count(), k);
      for (int row = 0; row < 25; ++row) {
        const double own =
            squared_distance(features, row, clustering.representatives[clustering.cluster_of[row]]);
        for (const int medoid : clustering.representatives) {
          ASSERT_LE(own, squared_distance(features, row, medoid) + 1e-6);
        }
      }
      for (int c = 0; c < k; ++c) {
        ASSERT_EQ(clustering.cluster_of[clustering.representatives[c]], c);
      }
    }
  }
}

TEST(Kmedoids, NoSingleExchangeIsBetter) {
  for (uint64_t seed = 0; seed < 40; ++seed) {
    const Features features = random_features(20, 3, seed);
    const std::vector<int> medoids = kmedoids(features, 4, 1000).representatives;
    const double reached = cost(features, medoids);
    for (size_t m = 0; m < medoids.size(); ++m) {
      for (int row = 0; row < features.rows; ++row) {
        std::vector<int> exchanged = medoids;
        exchanged[m] = row;
        ASSERT_GE(cost(features, exchanged), reached * (1 - 1e-5)) << "seed " << seed;
      }
    }
  }
}

TEST(Kmedoids, IsNearTheBestOfAll) {
  int optimal = 0;
  for (uint64_t seed = 0; seed < 60; ++seed) {
    const Features features = random_features(11, 2, seed);
    std::vector<int> medoids;
    const double least = least_cost(features, 3, 0, medoids);
    const double reached = cost(features, kmedoids(features, 3, 100).representatives);
    ASSERT_LE(reached, 1.5 * least) << "seed " << seed;
    optimal += reached < least * 1.0001;
  }
  EXPECT_GE(optimal, 50);
}

TEST(Kmedoids, EqualRowsAreOneCluster) {
  for (const float value : {0.0f, 3.0f, 1e6f}) {
    const Features features = make_features(std::vector<float>(24, value), 3);
    const Clustering clustering = kmedoids(features, 4, 100);
    EXPECT_EQ(clustering.representatives, std::vector<int>{0});
    EXPECT_EQ(clustering.cluster_of, std::vector<int>(8, 0));
  }
}

TEST(Kmedoids, GivesNoMoreClustersThanDifferentRows) {
  const Features features = make_features({5, 7, 5, 7, 5, 9, 5}, 1);
  EXPECT_EQ(kmedoids(features, 6, 100).count(), 3);
}

TEST(Kmedoids, OneRow) {
  const Clustering clustering = kmedoids(make_features({1, 2}, 2), 1, 100);
  EXPECT_EQ(clustering.representatives, std::vector<int>{0});
  EXPECT_EQ(clustering.cluster_of, std::vector<int>{0});
}

TEST(Kmedoids, ScaleDoesNotMatter) {
  const Features features = random_features(25, 4, 3);
  for (const float scale : {0x1p-20f, 0x1p20f}) {
    Features scaled = features;
    for (float& value : scaled.values) value *= scale;
    EXPECT_EQ(kmedoids(scaled, 5, 100).cluster_of, kmedoids(features, 5, 100).cluster_of);
  }
}

/// A dissimilarity that is not symmetric: what row i costs in the cluster of row m.
std::vector<float> random_costs(int rows, uint64_t seed) {
  Random random(seed, RandomStream::tests, 1);
  std::vector<float> costs(static_cast<size_t>(rows) * rows, 0.0f);
  for (int m = 0; m < rows; ++m) {
    // Some rows stand for others well without the reverse.
    const float scale = random.uniform(0.2f, 1);
    for (int i = 0; i < rows; ++i) {
      if (i != m) costs[static_cast<size_t>(m) * rows + i] = scale * random.uniform(0.01f, 1);
    }
  }
  return costs;
}

double cost(const std::vector<float>& costs, int rows, const std::vector<int>& medoids) {
  double sum = 0;
  for (int i = 0; i < rows; ++i) {
    float least = std::numeric_limits<float>::infinity();
    for (const int m : medoids) least = std::min(least, costs[static_cast<size_t>(m) * rows + i]);
    sum += double{least};
  }
  return sum;
}

/// The least cost of any `k` medoids, by trying all.
double least_cost(const std::vector<float>& costs, int rows, int k, int first,
                  std::vector<int>& medoids) {
  if (static_cast<int>(medoids.size()) == k) return cost(costs, rows, medoids);
  double least = std::numeric_limits<double>::infinity();
  for (int row = first; row < rows; ++row) {
    medoids.push_back(row);
    least = std::min(least, least_cost(costs, rows, k, row + 1, medoids));
    medoids.pop_back();
  }
  return least;
}

/// All rows may be medoids.
Clustering kmedoids_of(const std::vector<float>& values, int rows, int k) {
  MedoidCosts costs{std::vector<int>(rows), values};
  std::iota(costs.candidates.begin(), costs.candidates.end(), 0);
  return kmedoids(costs, rows, k, 100);
}

TEST(KmedoidsOfCosts, AreNearTheBestOfAll) {
  int optimal = 0;
  constexpr int cases = 100;
  for (uint64_t seed = 0; seed < cases; ++seed) {
    const int rows = 7 + static_cast<int>(seed % 4);
    const int k = 2 + static_cast<int>(seed % 3);
    const std::vector<float> costs = random_costs(rows, seed);
    const Clustering clustering = kmedoids_of(costs, rows, k);
    ASSERT_EQ(clustering.count(), k);
    const double reached = cost(costs, rows, clustering.representatives);
    std::vector<int> medoids;
    const double least = least_cost(costs, rows, k, 0, medoids);
    ASSERT_LE(reached, 1.5 * least) << "seed " << seed;
    optimal += reached < least * 1.0001;
    for (int i = 0; i < rows; ++i) {
      const int own = clustering.representatives[clustering.cluster_of[i]];
      for (const int m : clustering.representatives) {
        ASSERT_LE(costs[static_cast<size_t>(own) * rows + i],
                  costs[static_cast<size_t>(m) * rows + i]);
      }
    }
  }
  EXPECT_GE(optimal, cases * 9 / 10);
}

TEST(KmedoidsOfCosts, OneMedoidIsTheBest) {
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const std::vector<float> costs = random_costs(9, seed);
    std::vector<int> medoids;
    EXPECT_NEAR(cost(costs, 9, kmedoids_of(costs, 9, 1).representatives),
                least_cost(costs, 9, 1, 0, medoids), 1e-6);
  }
}

TEST(KmedoidsOfCosts, TheDirectionMatters) {
  // Row 1 stands for all others at no cost, and none of them for it.
  const std::vector<float> costs = {0, 5, 5, 0, 0, 0, 5, 5, 0};
  const Clustering clustering = kmedoids_of(costs, 3, 1);
  EXPECT_EQ(clustering.representatives, std::vector<int>{1});
  EXPECT_EQ(kmedoids_of(costs, 3, 2).count(), 1) << "a second one would save nothing";
}

TEST(KmedoidsOfCosts, OnlyCandidatesBecomeMedoids) {
  // Rows 0 and 3 may stand for the others; 0 is as good for 1 and 2 as 3 is bad.
  const MedoidCosts costs{{0, 3}, {0, 1, 1, 9, 9, 5, 5, 0}};
  const Clustering one = kmedoids(costs, 4, 1, 100);
  EXPECT_EQ(one.representatives, std::vector<int>{0});
  const Clustering two = kmedoids(costs, 4, 3, 100);
  EXPECT_EQ(two.representatives, (std::vector<int>{0, 3}));
  EXPECT_EQ(two.cluster_of, (std::vector<int>{0, 0, 0, 1}));
}

}  // namespace
}  // namespace relume

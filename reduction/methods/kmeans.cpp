#include "reduction/methods/kmeans.h"

#include <limits>
#include <optional>

#include "core/base/check.h"
#include "reduction/distance.h"

namespace relume {
namespace {

/// State of one run.
struct Run {
  const Features& features;
  int k;
  std::vector<float> centroids;  ///< k x dimensions
  std::vector<int> cluster_of;

  const float* centroid(int cluster) const {
    return &centroids[static_cast<size_t>(cluster) * features.dimensions];
  }
};

/// Assigns every row to its nearest centroid; true when any assignment changed.
bool assign(Run& run) {
  bool changed = false;
  for (int row = 0; row < run.features.rows; ++row) {
    int nearest = 0;
    float least = std::numeric_limits<float>::infinity();
    for (int cluster = 0; cluster < run.k; ++cluster) {
      const float d =
          squared_distance(run.features.row(row), run.centroid(cluster), run.features.dimensions);
      if (d < least) {
        least = d;
        nearest = cluster;
      }
    }
    changed = changed || run.cluster_of[row] != nearest;
    run.cluster_of[row] = nearest;
  }
  return changed;
}

/// Moves every centroid to the mean of its rows; empty ones stay.
void update(Run& run) {
  const int dimensions = run.features.dimensions;
  std::vector<double> sums(run.centroids.size(), 0.0);
  std::vector<int> members(run.k, 0);
  for (int row = 0; row < run.features.rows; ++row) {
    const int cluster = run.cluster_of[row];
    ++members[cluster];
    double* sum = &sums[static_cast<size_t>(cluster) * dimensions];
    for (int i = 0; i < dimensions; ++i) sum[i] += run.features.row(row)[i];
  }
  for (int cluster = 0; cluster < run.k; ++cluster) {
    if (members[cluster] == 0) continue;
    const size_t start = static_cast<size_t>(cluster) * dimensions;
    for (int i = 0; i < dimensions; ++i) {
      run.centroids[start + i] = static_cast<float>(sums[start + i] / members[cluster]);
    }
  }
}

/// Drops empty clusters and picks representatives.
Clustering finish(const Run& run) {
  std::vector<int> nearest(run.k, -1);
  std::vector<float> least(run.k, std::numeric_limits<float>::infinity());
  for (int row = 0; row < run.features.rows; ++row) {
    const int cluster = run.cluster_of[row];
    const float d =
        squared_distance(run.features.row(row), run.centroid(cluster), run.features.dimensions);
    if (nearest[cluster] < 0 || d < least[cluster]) {
      nearest[cluster] = row;
      least[cluster] = d;
    }
  }
  Clustering result;
  std::vector<int> renumbered(run.k, -1);
  for (int cluster = 0; cluster < run.k; ++cluster) {
    if (nearest[cluster] < 0) continue;
    renumbered[cluster] = result.count();
    result.representatives.push_back(nearest[cluster]);
  }
  for (const int cluster : run.cluster_of) result.cluster_of.push_back(renumbered[cluster]);
  return result;
}

Run run_lloyd(const Features& features, std::span<const int> seeds, int max_iterations) {
  Run run{features, static_cast<int>(seeds.size()), {}, std::vector<int>(features.rows, -1)};
  for (const int seed : seeds) {
    run.centroids.insert(run.centroids.end(), features.row(seed),
                         features.row(seed) + features.dimensions);
  }
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (!assign(run)) break;
    update(run);
  }
  return run;
}

double inertia(const Run& run) {
  double sum = 0;
  for (int row = 0; row < run.features.rows; ++row) {
    sum += squared_distance(run.features.row(row), run.centroid(run.cluster_of[row]),
                            run.features.dimensions);
  }
  return sum;
}

/// k-means++: each seed is drawn with probability proportional to its squared distance from the
/// seeds so far; when all remaining rows coincide with seeds, fewer than k come out.
std::vector<int> plus_plus_seeds(const Features& features, int k, Random& random) {
  std::vector<int> seeds{static_cast<int>(random.below(static_cast<uint32_t>(features.rows)))};
  std::vector<float> nearest(features.rows, std::numeric_limits<float>::infinity());
  while (static_cast<int>(seeds.size()) < k) {
    double total = 0;
    for (int row = 0; row < features.rows; ++row) {
      const float d =
          squared_distance(features.row(row), features.row(seeds.back()), features.dimensions);
      nearest[row] = std::min(nearest[row], d);
      total += nearest[row];
    }
    if (!(total > 0)) break;
    double threshold = random.uniform() * total;
    int chosen = -1;
    for (int row = 0; row < features.rows; ++row) {
      if (!(nearest[row] > 0)) continue;
      chosen = row;
      threshold -= nearest[row];
      if (threshold < 0) break;
    }
    seeds.push_back(chosen);
  }
  return seeds;
}

}  // namespace

Clustering kmeans(const Features& features, std::span<const int> seeds, int max_iterations) {
  CHECK_MSG(!seeds.empty() && static_cast<int>(seeds.size()) <= features.rows, "seeds {} rows {}",
            seeds.size(), features.rows);
  return finish(run_lloyd(features, seeds, max_iterations));
}

Clustering strong_kmeans(const Features& features, int k, int restarts, int max_iterations,
                         Random& random) {
  CHECK_MSG(k >= 1 && k <= features.rows && restarts >= 1, "k {} rows {} restarts {}", k,
            features.rows, restarts);
  std::optional<Run> best;
  double best_inertia = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < restarts; ++attempt) {
    Run run = run_lloyd(features, plus_plus_seeds(features, k, random), max_iterations);
    const double value = inertia(run);
    if (best && !(value < best_inertia)) continue;
    best_inertia = value;
    best.emplace(std::move(run));
  }
  return finish(*best);
}

}  // namespace relume

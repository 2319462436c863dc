#include "reduction/methods/cmeans.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "reduction/methods/kmeans.h"

namespace relume {
namespace {

constexpr float settled = 1e-3f;

/// State of one run.
struct Run {
  const Features& features;
  const FeatureColumns& columns;  ///< the features' own
  int k;
  std::vector<float> centroids;    ///< k x dimensions
  std::vector<float> distances;    ///< k x columns.stride, squared: see eval_centroid_distances
  std::vector<float> memberships;  ///< rows x k

  float* row_memberships(int row) { return &memberships[static_cast<size_t>(row) * k]; }
  const float* row_memberships(int row) const { return &memberships[static_cast<size_t>(row) * k]; }
  float distance(int row, int cluster) const {
    return distances[static_cast<size_t>(cluster) * columns.stride + row];
  }
};

/// Weighs a row's squared distances, in place, into memberships.
void share_row(std::vector<float>& values) {
  const auto nearest = std::min_element(values.begin(), values.end());
  const float least = *nearest;
  if (!(least > 0)) {
    const auto index = nearest - values.begin();
    std::fill(values.begin(), values.end(), 0.0f);
    values[index] = 1;
    return;
  }
  // Relative to the nearest, so that nothing over- or underflows to 0 / 0. On squared distances the
  // exponent is 1 / (m - 1) = 2.
  static_assert(cmeans_fuzziness == 1.5);
  float sum = 0;
  for (float& value : values) {
    const float ratio = least / value;
    value = ratio * ratio;
    sum += value;
  }
  for (float& value : values) value /= sum;
}

/// Distances of all rows from the centroids where they are now.
void eval_centroid_distances(Run& run) {
  eval_distances(run.columns, run.centroids.data(), run.k, run.distances.data());
}

/// New memberships; the largest change.
float update_memberships(Run& run) {
  eval_centroid_distances(run);
  std::vector<float> values(run.k);
  float most = 0;
  for (int row = 0; row < run.features.rows; ++row) {
    for (int cluster = 0; cluster < run.k; ++cluster) values[cluster] = run.distance(row, cluster);
    share_row(values);
    float* memberships = run.row_memberships(row);
    for (int cluster = 0; cluster < run.k; ++cluster) {
      most = std::max(most, std::abs(values[cluster] - memberships[cluster]));
      memberships[cluster] = values[cluster];
    }
  }
  return most;
}

/// Moves the centroids to the weighted means; one without weight stays.
void update_centroids(Run& run) {
  const int dimensions = run.features.dimensions;
  std::vector<double> sums(run.centroids.size(), 0.0);
  std::vector<double> totals(run.k, 0.0);
  for (int row = 0; row < run.features.rows; ++row) {
    const float* values = run.features.row(row);
    for (int cluster = 0; cluster < run.k; ++cluster) {
      const double u = run.row_memberships(row)[cluster];
      const double weight = u * std::sqrt(u);  // u^m
      if (!(weight > 0)) continue;
      totals[cluster] += weight;
      double* sum = &sums[static_cast<size_t>(cluster) * dimensions];
      for (int i = 0; i < dimensions; ++i) sum[i] += weight * values[i];
    }
  }
  for (int cluster = 0; cluster < run.k; ++cluster) {
    if (!(totals[cluster] > 0)) continue;
    const size_t start = static_cast<size_t>(cluster) * dimensions;
    for (int i = 0; i < dimensions; ++i) {
      run.centroids[start + i] = static_cast<float>(sums[start + i] / totals[cluster]);
    }
  }
}

/// Starts at the centroids of a hard clustering.
Run start_run(const Features& features, const FeatureColumns& columns,
              const Clustering& clustering) {
  Run run{features, columns, clustering.count(), {}, {}, {}};
  run.distances.resize(static_cast<size_t>(run.k) * columns.stride);
  run.centroids.assign(static_cast<size_t>(run.k) * features.dimensions, 0.0f);
  run.memberships.assign(static_cast<size_t>(features.rows) * run.k, 0.0f);
  for (int row = 0; row < features.rows; ++row) {
    run.row_memberships(row)[clustering.cluster_of[row]] = 1;
  }
  update_centroids(run);
  return run;
}

/// Per cluster the member of the hard cut nearest its centroid, or -1 where the cut is empty.
std::vector<int> cut(const Run& run) {
  std::vector<int> representatives(run.k, -1);
  std::vector<float> least(run.k, std::numeric_limits<float>::infinity());
  for (int row = 0; row < run.features.rows; ++row) {
    const float* memberships = run.row_memberships(row);
    const auto cluster =
        static_cast<int>(std::max_element(memberships, memberships + run.k) - memberships);
    const float d = run.distance(row, cluster);
    if (representatives[cluster] >= 0 && !(d < least[cluster])) continue;
    representatives[cluster] = row;
    least[cluster] = d;
  }
  return representatives;
}

/// Keeps the clusters that have a representative. A row's largest membership is always among them.
FuzzyClustering finish(const Run& run) {
  const std::vector<int> representatives = cut(run);
  FuzzyClustering result;
  for (int row = 0; row < run.features.rows; ++row) {
    const float* memberships = run.row_memberships(row);
    double total = 0;
    for (int cluster = 0; cluster < run.k; ++cluster) {
      if (representatives[cluster] >= 0) total += memberships[cluster];
    }
    for (int cluster = 0; cluster < run.k; ++cluster) {
      if (representatives[cluster] < 0) continue;
      result.memberships.push_back(static_cast<float>(memberships[cluster] / total));
    }
  }
  for (const int representative : representatives) {
    if (representative >= 0) result.representatives.push_back(representative);
  }
  return result;
}

}  // namespace

FuzzyClustering cmeans(const Features& features, int k, int restarts, int max_iterations,
                       Random& random) {
  KmeansBuffers buffers;
  const Clustering start = strong_kmeans(features, k, restarts, max_iterations, random, buffers);
  Run run = start_run(features, buffers.columns, start);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    if (update_memberships(run) < settled) break;
    update_centroids(run);
  }
  eval_centroid_distances(run);
  return finish(run);
}

}  // namespace relume

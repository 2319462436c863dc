#include "reduction/methods/kmeans.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"
#include "core/simd/row_kernels.h"

namespace relume {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

void start_run(KmeansRun& run, int rows, int stride, int k) {
  run.rows = rows;
  run.stride = stride;
  run.distances.resize(static_cast<size_t>(k) * stride);
  run.cluster_of.assign(rows, -1);
  run.nearest.resize(stride);
  run.members.assign(k, 0);
  run.changed.assign(k, false);
  run.variances.assign(k, 0.0f);
}

/// Assigns every row to its nearest centroid; true when any assignment changed.
bool assign(KmeansRun& run) {
  best_row_kernels().nearest(run.distances.data(), run.k(), run.stride, run.nearest.data());
  bool any = false;
  for (int row = 0; row < run.rows; ++row) {
    const int before = run.cluster_of[row];
    const int now = run.nearest[row];
    if (now == before) continue;
    any = true;
    run.cluster_of[row] = now;
    run.changed[now] = true;
    ++run.members[now];
    if (before < 0) continue;
    run.changed[before] = true;
    --run.members[before];
  }
  return any;
}

void sort_by_cluster(KmeansRun& run) {
  run.sorted.resize(run.rows);
  run.ends.resize(run.k());
  int start = 0;
  for (int cluster = 0; cluster < run.k(); ++cluster) {
    run.ends[cluster] = start;
    start += run.members[cluster];
  }
  for (int row = 0; row < run.rows; ++row) run.sorted[run.ends[run.cluster_of[row]]++] = row;
}

/// Calls place(cluster, members) for the changed clusters that have members; empty ones stay where
/// they are.
template <class Place>
void update_changed(KmeansRun& run, const Place& place) {
  sort_by_cluster(run);
  for (int cluster = 0; cluster < run.k(); ++cluster) {
    if (!run.changed[cluster]) continue;
    run.changed[cluster] = false;
    const int count = run.members[cluster];
    if (count > 0) place(cluster, std::span(&run.sorted[run.ends[cluster] - count], count));
  }
}

/// Moves the centroids of changed clusters to the mean of their rows.
void update(KmeansRun& run, const Features& features, const FeatureColumns& columns) {
  const int dimensions = features.dimensions;
  run.centroid.resize(dimensions);
  update_changed(run, [&](int cluster, std::span<const int> members) {
    run.sum.assign(dimensions, 0.0);
    for (const int row : members) {
      const float* values = features.row(row);
      for (int i = 0; i < dimensions; ++i) run.sum[i] += values[i];
    }
    const auto count = static_cast<double>(members.size());
    for (int i = 0; i < dimensions; ++i) run.centroid[i] = static_cast<float>(run.sum[i] / count);
    eval_distances(columns, run.centroid.data(), 1, run.distances_of(cluster));
  });
}

/// The same from distances of pairs alone.
void update_by_pairs(KmeansRun& run, const PairDistances& pairs) {
  update_changed(run, [&](int cluster, std::span<const int> members) {
    run.variances[cluster] = best_row_kernels().centroid_distances(
        pairs.values.data(), pairs.stride, members.data(), static_cast<int>(members.size()),
        run.distances_of(cluster));
  });
}

/// The sum of squared distances of rows from their centroids, after update_by_pairs. 0 where all
/// rows of every cluster coincide.
double inertia(const KmeansRun& run) {
  double sum = 0;
  for (int cluster = 0; cluster < run.k(); ++cluster) {
    if (run.members[cluster] > 0) sum += double{run.variances[cluster]} * run.members[cluster];
  }
  return sum;
}

/// Drops empty clusters and picks representatives.
Clustering finish(const KmeansRun& run) {
  std::vector<int> representatives(run.k(), -1);
  for (int row = 0; row < run.rows; ++row) {
    const int cluster = run.cluster_of[row];
    int& representative = representatives[cluster];
    const float* distances = run.distances_of(cluster);
    if (representative < 0 || distances[row] < distances[representative]) representative = row;
  }
  Clustering result{run.cluster_of, {}};
  std::vector<int> renumbered(run.k(), -1);
  for (int cluster = 0; cluster < run.k(); ++cluster) {
    if (representatives[cluster] < 0) continue;
    renumbered[cluster] = result.count();
    result.representatives.push_back(representatives[cluster]);
  }
  for (int& cluster : result.cluster_of) cluster = renumbered[cluster];
  return result;
}

/// A row drawn in proportion to its weight, or -1 when all are 0. `sums` holds the lanes' sums of
/// `weights`, as RowKernels::lower leaves them; the draw descends a tree over them.
int draw_row(std::span<const float> weights, std::span<const float, row_lanes> sums,
             Random& random) {
  float tree[2 * row_lanes];
  std::copy(sums.begin(), sums.end(), tree + row_lanes);
  for (int node = row_lanes - 1; node > 0; --node) tree[node] = tree[2 * node] + tree[2 * node + 1];
  if (!(tree[1] > 0)) return -1;
  float threshold = random.uniform() * tree[1];
  int node = 1;
  while (node < row_lanes) {  // without branches: none could be predicted
    const float left = tree[2 * node];
    const int right =
        static_cast<int>(!(threshold < left)) & static_cast<int>(tree[2 * node + 1] > 0);
    threshold -= static_cast<float>(right) * left;
    node = 2 * node + right;
  }
  int chosen = -1;
  for (size_t row = node - row_lanes; row < weights.size(); row += row_lanes) {
    if (!(weights[row] > 0)) continue;
    chosen = static_cast<int>(row);
    threshold -= weights[row];
    if (threshold < 0) break;
  }
  return chosen;
}

/// k-means++: each seed is drawn with probability proportional to its squared distance from the
/// seeds so far; when all remaining rows coincide with seeds, fewer than k come out.
void draw_seeds(KmeansBuffers& buffers, int k, Random& random) {
  const PairDistances& pairs = buffers.pairs;
  std::vector<float>& nearest = buffers.nearest_seed;
  nearest.assign(pairs.stride, 0.0f);
  std::fill_n(nearest.begin(), pairs.rows, infinite);
  buffers.seeds.clear();
  int seed = static_cast<int>(random.below(static_cast<uint32_t>(pairs.rows)));
  while (seed >= 0) {
    buffers.seeds.push_back(seed);
    if (static_cast<int>(buffers.seeds.size()) == k) return;
    float sums[row_lanes];
    best_row_kernels().lower(pairs.row(seed), pairs.stride, nearest.data(), sums);
    seed = draw_row(nearest, sums, random);
  }
}

}  // namespace

Clustering kmeans(const Features& features, std::span<const int> seeds, int max_iterations) {
  CHECK_MSG(!seeds.empty() && static_cast<int>(seeds.size()) <= features.rows, "seeds {} rows {}",
            seeds.size(), features.rows);
  FeatureColumns columns;
  make_feature_columns(features, columns);
  KmeansRun run;
  start_run(run, features.rows, columns.stride, static_cast<int>(seeds.size()));
  for (int cluster = 0; cluster < run.k(); ++cluster) {
    eval_distances(columns, features.row(seeds[cluster]), 1, run.distances_of(cluster));
  }
  for (int iteration = 0; iteration < max_iterations && assign(run); ++iteration) {
    update(run, features, columns);
  }
  return finish(run);
}

Clustering strong_kmeans(const Features& features, int k, int restarts, int max_iterations,
                         Random& random, KmeansBuffers& buffers) {
  CHECK_MSG(k >= 1 && k <= features.rows && restarts >= 1, "k {} rows {} restarts {}", k,
            features.rows, restarts);
  const PairDistances& pairs = buffers.pairs;
  KmeansRun& run = buffers.run;
  make_pair_distances(features, buffers.columns, buffers.pairs);
  double best_inertia = 0;
  // Any seed leads to the same single cluster.
  const int runs = k == 1 ? 1 : restarts;
  for (int attempt = 0; attempt < runs; ++attempt) {
    draw_seeds(buffers, k, random);
    start_run(run, pairs.rows, pairs.stride, static_cast<int>(buffers.seeds.size()));
    for (int cluster = 0; cluster < run.k(); ++cluster) {
      std::copy_n(pairs.row(buffers.seeds[cluster]), pairs.stride, run.distances_of(cluster));
    }
    for (int iteration = 0; iteration < max_iterations && assign(run); ++iteration) {
      update_by_pairs(run, pairs);
    }
    const double value = inertia(run);
    if (attempt > 0 && !(value < best_inertia)) continue;
    best_inertia = value;
    std::swap(run, buffers.best);
    if (!(value > 0)) break;  // all rows of a cluster coincide: nothing is better
  }
  // Once more in space, for the representatives: see the header.
  KmeansRun& best = buffers.best;
  std::fill(best.changed.begin(), best.changed.end(), true);
  update(best, features, buffers.columns);
  return finish(best);
}

}  // namespace relume

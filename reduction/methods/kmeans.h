#pragma once

#include "core/base/random.h"
#include "reduction/feature_columns.h"

namespace relume {

/// Lloyd's k-means (MacQueen 1967; TR2007-600 sec. 3.1) on the rows of `features`.
/// Decisions where the report is silent: ties go to the lower cluster or row index; it stops when
/// no assignment changes or after `max_iterations`; a centroid that loses all its rows stays where
/// it is and is dropped at the end, so fewer than k clusters may come out. The representative is
/// the member nearest its centroid. `seeds` holds k row indices, the initial centroids: {0, 1, ...,
/// k-1} is the report's "first k samples", in sampling order.
Clustering kmeans(const Features& features, std::span<const int> seeds, int max_iterations);

/// State of one run of k-means. A centroid is known by its squared distances from all rows.
struct KmeansRun {
  int rows = 0;
  int stride = 0;                ///< rows, padded to a multiple of row_lanes
  std::vector<float> distances;  ///< per cluster: stride
  std::vector<int> cluster_of;   ///< per row; -1 before the first assignment
  std::vector<int> nearest;      ///< stride: the next assignment
  std::vector<int> members;      ///< per cluster
  std::vector<char> changed;     ///< per cluster: members differ from those its centroid is of
  std::vector<float> variances;  ///< per cluster: mean squared distance of members from centroid
  std::vector<int> sorted;       ///< rows by cluster, ascending within one
  std::vector<int> ends;         ///< per cluster, where its rows end in `sorted`
  std::vector<double> sum;       ///< dimensions: working memory
  std::vector<float> centroid;   ///< dimensions: working memory

  int k() const { return static_cast<int>(members.size()); }
  float* distances_of(int cluster) { return &distances[static_cast<size_t>(cluster) * stride]; }
  const float* distances_of(int cluster) const {
    return &distances[static_cast<size_t>(cluster) * stride];
  }
};

/// Working memory of strong_kmeans, for one thread to keep between pixels.
struct KmeansBuffers {
  FeatureColumns columns;  ///< of the features last given
  PairDistances pairs;
  std::vector<int> seeds;
  std::vector<float> nearest_seed;  ///< stride: squared distance of each row
  KmeansRun run;
  KmeansRun best;
};

/// Strong k-means: k-means++ seeding (Arthur and Vassilvitskii 2007), `restarts` runs, the one with
/// the least sum of squared distances wins, ties to the earlier; a sum of 0 ends it early. Runs
/// rest on the distances of pairs of rows: O(rows^2 (dimensions + iterations)), with rows^2 floats
/// of memory. Representatives are nearest to the centroid as it lies in space, rounded to float:
/// from pairs the two members of a cluster of two are equally near, and were it always the lower
/// row, records would lean to the side of the pixel that is sampled first (3% more error on
/// spheres).
Clustering strong_kmeans(const Features& features, int k, int restarts, int max_iterations,
                         Random& random, KmeansBuffers& buffers);

}  // namespace relume

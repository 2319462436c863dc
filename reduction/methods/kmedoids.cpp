#include "reduction/methods/kmedoids.h"

#include <limits>

#include "core/base/check.h"
#include "reduction/distance.h"

namespace relume {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// State of one run.
struct Run {
  int rows;
  std::vector<float> distances;  ///< medoid x row
  std::vector<int> medoids;
  std::vector<int> nearest;   ///< per row, index into medoids
  std::vector<float> first;   ///< per row, distance to the nearest medoid
  std::vector<float> second;  ///< and to the second nearest

  const float* distances_of(int row) const { return &distances[static_cast<size_t>(row) * rows]; }
};

std::vector<float> squared_distances(const Features& features) {
  const int rows = features.rows;
  std::vector<float> distances(static_cast<size_t>(rows) * rows, 0.0f);
  for (int a = 0; a < rows; ++a) {
    for (int b = 0; b < a; ++b) {
      const float d = squared_distance(features.row(a), features.row(b), features.dimensions);
      distances[static_cast<size_t>(a) * rows + b] = d;
      distances[static_cast<size_t>(b) * rows + a] = d;
    }
  }
  return distances;
}

void find_nearest(Run& run) {
  run.nearest.assign(run.rows, 0);
  run.first.assign(run.rows, infinite);
  run.second.assign(run.rows, infinite);
  for (int m = 0; m < static_cast<int>(run.medoids.size()); ++m) {
    const float* distances = run.distances_of(run.medoids[m]);
    for (int row = 0; row < run.rows; ++row) {
      const float d = distances[row];
      if (d < run.first[row]) {
        run.second[row] = run.first[row];
        run.first[row] = d;
        run.nearest[row] = m;
      } else {
        run.second[row] = std::min(run.second[row], d);
      }
    }
  }
}

/// The row that, added to the medoids, lowers the sum most; -1 when none does.
int best_addition(const Run& run) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int row = 0; row < run.rows; ++row) {
    if (!(run.first[row] > 0)) continue;
    const float* distances = run.distances_of(row);
    double sum = 0;
    for (int other = 0; other < run.rows; ++other) {
      sum += std::min(distances[other], run.first[other]);
    }
    if (!(sum < least)) continue;
    least = sum;
    best = row;
  }
  return best;
}

/// Per medoid, how much the sum grows when it alone is taken away.
std::vector<double> removal_losses(const Run& run) {
  std::vector<double> losses(run.medoids.size(), 0.0);
  for (int row = 0; row < run.rows; ++row) {
    losses[run.nearest[row]] += double{run.second[row]} - run.first[row];
  }
  return losses;
}

/// Makes the exchange that lowers the sum most; false when none does, by more than rounding.
bool make_best_exchange(Run& run) {
  const std::vector<double> losses = removal_losses(run);
  double total = 0;
  for (const float d : run.first) total += d;
  double best_change = -1e-6 * total;
  int best_row = -1;
  size_t best_medoid = 0;
  std::vector<double> changes;
  for (int row = 0; row < run.rows; ++row) {
    if (!(run.first[row] > 0)) continue;  // a medoid, or equal to one
    const float* distances = run.distances_of(row);
    changes = losses;
    double shared = 0;  // what every exchange with this row gains
    for (int other = 0; other < run.rows; ++other) {
      const double d = distances[other];
      const double first = run.first[other];
      if (d < first) {
        shared += d - first;
        changes[run.nearest[other]] += first - run.second[other];
      } else if (d < run.second[other]) {
        changes[run.nearest[other]] += d - run.second[other];
      }
    }
    for (size_t m = 0; m < changes.size(); ++m) {
      if (!(changes[m] + shared < best_change)) continue;
      best_change = changes[m] + shared;
      best_row = row;
      best_medoid = m;
    }
  }
  if (best_row < 0) return false;
  run.medoids[best_medoid] = best_row;
  return true;
}

}  // namespace

Clustering kmedoids(const Features& features, int k, int max_iterations) {
  return kmedoids(squared_distances(features), features.rows, k, max_iterations);
}

Clustering kmedoids(std::vector<float> distances, int rows, int k, int max_iterations) {
  CHECK_MSG(k >= 1 && k <= rows && distances.size() == static_cast<size_t>(rows) * rows,
            "k {} rows {}", k, rows);
  Run run{rows, std::move(distances), {}, {}, {}, {}};
  // With no medoid yet every row is as far as can be summed.
  float farthest = 0;
  for (const float d : run.distances) farthest = std::max(farthest, d);
  run.first.assign(run.rows, farthest > 0 ? farthest : 1.0f);
  while (static_cast<int>(run.medoids.size()) < k) {
    const int row = best_addition(run);
    if (row < 0) break;
    run.medoids.push_back(row);
    find_nearest(run);
  }
  // With one medoid BUILD has found the best already.
  for (int i = 0; run.medoids.size() > 1 && i < max_iterations; ++i) {
    if (!make_best_exchange(run)) break;
    find_nearest(run);
  }
  return {run.nearest, run.medoids};
}

}  // namespace relume

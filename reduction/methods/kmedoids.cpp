#include "reduction/methods/kmedoids.h"

#include <limits>
#include <numeric>

#include "core/base/check.h"
#include "reduction/feature_columns.h"

namespace relume {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

/// State of one run.
struct Run {
  const MedoidCosts& costs;
  int rows;
  std::vector<int> medoids;   ///< indices into candidates
  std::vector<int> nearest;   ///< per row, index into medoids
  std::vector<float> first;   ///< per row, cost with the nearest medoid
  std::vector<float> second;  ///< and with the second nearest

  int candidate_count() const { return static_cast<int>(costs.candidates.size()); }
  int row_of(int candidate) const { return costs.candidates[candidate]; }
  const float* costs_of(int candidate) const {
    return &costs.values[static_cast<size_t>(candidate) * rows];
  }
};

MedoidCosts squared_distances(const Features& features) {
  FeatureColumns columns;
  PairDistances pairs;
  make_pair_distances(features, columns, pairs);
  const int rows = features.rows;
  MedoidCosts costs{std::vector<int>(rows), {}};
  std::iota(costs.candidates.begin(), costs.candidates.end(), 0);
  costs.values.reserve(static_cast<size_t>(rows) * rows);
  for (int row = 0; row < rows; ++row) {
    costs.values.insert(costs.values.end(), pairs.row(row), pairs.row(row) + rows);
  }
  return costs;
}

void find_nearest(Run& run) {
  run.nearest.assign(run.rows, 0);
  run.first.assign(run.rows, infinite);
  run.second.assign(run.rows, infinite);
  for (int m = 0; m < static_cast<int>(run.medoids.size()); ++m) {
    const float* distances = run.costs_of(run.medoids[m]);
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

/// The candidate that, added to the medoids, lowers the sum most; -1 when none does.
int best_addition(const Run& run) {
  int best = -1;
  double least = std::numeric_limits<double>::infinity();
  for (int candidate = 0; candidate < run.candidate_count(); ++candidate) {
    if (!(run.first[run.row_of(candidate)] > 0)) continue;
    const float* distances = run.costs_of(candidate);
    double sum = 0;
    for (int other = 0; other < run.rows; ++other) {
      sum += std::min(distances[other], run.first[other]);
    }
    if (!(sum < least)) continue;
    least = sum;
    best = candidate;
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
  int best_candidate = -1;
  size_t best_medoid = 0;
  std::vector<double> changes;
  for (int candidate = 0; candidate < run.candidate_count(); ++candidate) {
    if (!(run.first[run.row_of(candidate)] > 0)) continue;  // a medoid, or equal to one
    const float* distances = run.costs_of(candidate);
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
      best_candidate = candidate;
      best_medoid = m;
    }
  }
  if (best_candidate < 0) return false;
  run.medoids[best_medoid] = best_candidate;
  return true;
}

}  // namespace

Clustering kmedoids(const Features& features, int k, int max_iterations) {
  return kmedoids(squared_distances(features), features.rows, k, max_iterations);
}

Clustering kmedoids(const MedoidCosts& costs, int rows, int k, int max_iterations) {
  CHECK_MSG(k >= 1 && k <= rows &&
                costs.values.size() == costs.candidates.size() * static_cast<size_t>(rows),
            "k {} rows {}", k, rows);
  Run run{costs, rows, {}, {}, {}, {}};
  // With no medoid yet every row is as far as can be summed.
  float farthest = 0;
  for (const float d : costs.values) farthest = std::max(farthest, d);
  run.first.assign(rows, farthest > 0 ? farthest : 1.0f);
  while (static_cast<int>(run.medoids.size()) < k) {
    const int candidate = best_addition(run);
    if (candidate < 0) break;
    run.medoids.push_back(candidate);
    find_nearest(run);
  }
  // With one medoid BUILD has found the best already.
  for (int i = 0; run.medoids.size() > 1 && i < max_iterations; ++i) {
    if (!make_best_exchange(run)) break;
    find_nearest(run);
  }
  for (int& medoid : run.medoids) medoid = run.row_of(medoid);
  return {std::move(run.nearest), std::move(run.medoids)};
}

}  // namespace relume

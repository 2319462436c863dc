#include "reduction/methods/light_fit_clusters.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"

namespace relume {
namespace {

constexpr int max_iterations = 30;

struct KernelRun {
  const std::vector<float>& gram;
  int n;
  int k;
  std::vector<int> cluster_of;
  std::vector<int> members;     ///< per cluster
  std::vector<float> within;    ///< per cluster: sum of gram over pairs of members
  std::vector<float> to_point;  ///< k x n: sum of gram between members and the point
  double inertia = 0;

  float at(int i, int j) const { return gram[static_cast<size_t>(i) * n + j]; }
};

float distance(const KernelRun& run, int i, int j) {
  return std::max(0.0f, run.at(i, i) + run.at(j, j) - 2 * run.at(i, j));
}

std::vector<int> draw_seeds(const KernelRun& run, Random& random) {
  std::vector<int> seeds{static_cast<int>(random.below(static_cast<uint32_t>(run.n)))};
  std::vector<float> nearest(run.n, std::numeric_limits<float>::infinity());
  while (static_cast<int>(seeds.size()) < run.k) {
    double total = 0;
    for (int i = 0; i < run.n; ++i) {
      nearest[i] = std::min(nearest[i], distance(run, i, seeds.back()));
      total += nearest[i];
    }
    if (!(total > 0)) break;
    double threshold = random.uniform() * total;
    int chosen = -1;
    for (int i = 0; i < run.n && !(chosen >= 0 && threshold < 0); ++i) {
      if (!(nearest[i] > 0)) continue;
      chosen = i;
      threshold -= nearest[i];
    }
    seeds.push_back(chosen);
  }
  return seeds;
}

/// Sums of the kernel that distances to centroids need.
void sum_clusters(KernelRun& run) {
  std::fill(run.members.begin(), run.members.end(), 0);
  std::fill(run.within.begin(), run.within.end(), 0.0f);
  std::fill(run.to_point.begin(), run.to_point.end(), 0.0f);
  for (int i = 0; i < run.n; ++i) {
    const int c = run.cluster_of[i];
    ++run.members[c];
    float* sums = &run.to_point[static_cast<size_t>(c) * run.n];
    const float* row = &run.gram[static_cast<size_t>(i) * run.n];
    for (int j = 0; j < run.n; ++j) sums[j] += row[j];
  }
  for (int i = 0; i < run.n; ++i) {
    const int c = run.cluster_of[i];
    run.within[c] += run.to_point[static_cast<size_t>(c) * run.n + i];
  }
}

/// One Lloyd step; true when an assignment changed.
bool reassign(KernelRun& run) {
  bool changed = false;
  run.inertia = 0;
  for (int i = 0; i < run.n; ++i) {
    float least = std::numeric_limits<float>::infinity();
    int nearest = run.cluster_of[i];
    for (int c = 0; c < run.k; ++c) {
      if (run.members[c] == 0) continue;
      const float count = static_cast<float>(run.members[c]);
      const float d = run.at(i, i) - 2 * run.to_point[static_cast<size_t>(c) * run.n + i] / count +
                      run.within[c] / (count * count);
      if (d < least) {
        least = d;
        nearest = c;
      }
    }
    changed = changed || nearest != run.cluster_of[i];
    run.cluster_of[i] = nearest;
    run.inertia += std::max(0.0f, least);
  }
  return changed;
}

void run_lloyd(KernelRun& run, const std::vector<int>& seeds) {
  run.k = static_cast<int>(seeds.size());
  for (int i = 0; i < run.n; ++i) {
    int nearest = 0;
    for (int c = 1; c < run.k; ++c) {
      if (distance(run, i, seeds[c]) < distance(run, i, seeds[nearest])) nearest = c;
    }
    run.cluster_of[i] = nearest;
  }
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    sum_clusters(run);
    if (!reassign(run)) break;
  }
}

}  // namespace

std::vector<int> kernel_kmeans(const std::vector<float>& gram, int n, int k, int restarts,
                               Random& random) {
  CHECK_MSG(k >= 1 && k <= n && gram.size() == static_cast<size_t>(n) * n, "n {} k {}", n, k);
  KernelRun run{gram,
                n,
                k,
                std::vector<int>(n),
                std::vector<int>(k),
                std::vector<float>(k),
                std::vector<float>(static_cast<size_t>(k) * n)};
  std::vector<int> best;
  double least = std::numeric_limits<double>::infinity();
  for (int attempt = 0; attempt < restarts; ++attempt) {
    run.k = k;
    run_lloyd(run, draw_seeds(run, random));
    if (!best.empty() && !(run.inertia < least)) continue;
    least = run.inertia;
    best = run.cluster_of;
  }
  std::vector<int> renumbered(k, -1);
  int used = 0;
  for (int& c : best) {
    if (renumbered[c] < 0) renumbered[c] = used++;
    c = renumbered[c];
  }
  return best;
}

}  // namespace relume

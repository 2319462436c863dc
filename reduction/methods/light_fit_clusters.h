#pragma once

#include <vector>

#include "core/base/random.h"

namespace relume {

/// k-means in the space of a kernel: `gram` is n x n, symmetric, positive semi-definite; distances
/// come from it alone. k-means++ seeding, `restarts` runs, least inertia wins, ties to the earlier
/// run and the lower index. Returns a cluster in [0, k') per point, k' <= k, none empty.
std::vector<int> kernel_kmeans(const std::vector<float>& gram, int n, int k, int restarts,
                               Random& random);

}  // namespace relume

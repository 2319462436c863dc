#pragma once

#include "core/base/random.h"
#include "reduction/features.h"

namespace relume {

/// Lloyd's k-means (MacQueen 1967; TR2007-600 sec. 3.1) on the rows of `features`.
/// Decisions where the report is silent: ties go to the lower cluster or row index; it stops when
/// no assignment changes or after `max_iterations`; a centroid that loses all its rows stays where
/// it is and is dropped at the end, so fewer than k clusters may come out. The representative is
/// the member nearest its centroid. `seeds` holds k row indices, the initial centroids: {0, 1, ...,
/// k-1} is the report's "first k samples", in sampling order.
Clustering kmeans(const Features& features, std::span<const int> seeds, int max_iterations);

/// Strong k-means: k-means++ seeding (Arthur and Vassilvitskii 2007), `restarts` runs, the one with
/// the least sum of squared distances wins, ties to the earlier.
Clustering strong_kmeans(const Features& features, int k, int restarts, int max_iterations,
                         Random& random);

}  // namespace relume

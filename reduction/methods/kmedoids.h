#pragma once

#include "reduction/features.h"

namespace relume {

/// Partitioning around medoids (Kaufman and Rousseeuw 1990): k rows, the medoids, such that the sum
/// of every row's squared Euclidean distance to the nearest is small. BUILD adds the row that
/// lowers the sum most, one at a time; SWAP exchanges the medoid and the row that lower it most,
/// until no exchange does or after `max_iterations` (all k exchanges of a row at once: Schubert and
/// Rousseeuw 2019, FastPAM1). Deterministic; ties to the lower row, then the lower cluster. The
/// representative is the medoid. When k medoids are more than there are different rows, fewer come
/// out. Squared distances make it minimise the same sum as k-means. O(rows^2) memory; O(rows^2)
/// time an exchange.
Clustering kmedoids(const Features& features, int k, int max_iterations);

/// The same for any dissimilarity: distances[m * rows + i] >= 0 is what row i costs when row m is
/// its medoid, 0 for i = m; it need not be symmetric.
Clustering kmedoids(std::vector<float> distances, int rows, int k, int max_iterations);

}  // namespace relume

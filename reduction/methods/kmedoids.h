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

/// Any dissimilarity of rows from those among them that may be medoids; it need not be symmetric.
struct MedoidCosts {
  std::vector<int> candidates;  ///< rows, ascending
  std::vector<float>
      values;  ///< [m * rows + i] >= 0: what row i costs with candidates[m] as medoid
};

/// The same over `rows` rows, of which only the candidates may become medoids; a medoid must cost 0
/// with itself. Memory and time of an exchange are candidates * rows.
Clustering kmedoids(const MedoidCosts& costs, int rows, int k, int max_iterations);

}  // namespace relume

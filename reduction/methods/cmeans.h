#pragma once

#include "core/base/random.h"
#include "reduction/features.h"

namespace relume {

/// The fuzzifier m: 1 would be k-means, large values share every row equally.
inline constexpr double cmeans_fuzziness = 1.5;

/// Fuzzy C-means (Bezdek 1981), which TR2007-600 sec. 5 asks for, on the rows of `features`:
/// memberships u and centroids c in turn minimise sum over i, j of u_ij^m |x_i - c_j|^2 with sum
/// over j of u_ij = 1:
///   u_ij = 1 / sum over h of (|x_i - c_j| / |x_i - c_h|)^(2 / (m - 1)),
///   c_j = sum over i of u_ij^m x_i / sum over i of u_ij^m.
/// Starts from strong k-means and stops when no membership moves by 1e-3 or after `max_iterations`.
/// A row that lies on centroids, where the quotient is 0 / 0, belongs to the first of them alone.
/// The hard cut, each row to its largest membership, gives the representatives: the member nearest
/// the centroid. Clusters that the cut leaves empty are dropped and their memberships divided among
/// the others. Ties to the lower index throughout.
FuzzyClustering cmeans(const Features& features, int k, int restarts, int max_iterations,
                       Random& random);

}  // namespace relume

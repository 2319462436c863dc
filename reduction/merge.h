#pragma once

#include "core/samples/sample_tile.h"
#include "reduction/sample_matrix.h"

namespace relume {

/// Merges each cluster into one record and appends it to `out` (TR2007-600 sec. 2.1 and eq. 3).
/// Fields of category average get the mean of all members, representative ones the value of the
/// cluster's representative. Unit directions are averaged and made unit again, which the report
/// does not mention; axes (strand tangents) are turned to the representative's side first, since
/// their sign means nothing; where a mean vanishes, the representative's value stands. A record's
/// weight is `weight_per_sample` times its members.
///
/// Each record gets its cluster's footprint and up to `stored_members` of its members.
void merge_clusters(const SampleMatrix& samples, const Clustering& clustering,
                    float weight_per_sample, TypedRows& out, int stored_members = 0);

/// The same with shared rows: means are weighted by membership, and a record's weight is
/// `weight_per_sample` times the sum of its memberships, so that all weights still sum to the
/// rows'. A footprint counts the rows that belong to no other cluster more.
void merge_fuzzy_clusters(const SampleMatrix& samples, const FuzzyClustering& clustering,
                          float weight_per_sample, TypedRows& out, int stored_members = 0);

/// Every row becomes a record of weight `weight_per_sample` and no extent.
void copy_rows(const SampleMatrix& samples, float weight_per_sample, TypedRows& out);

}  // namespace relume

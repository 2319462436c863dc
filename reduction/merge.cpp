#include "reduction/merge.h"

#include <numeric>
#include <span>

#include "core/base/check.h"

namespace relume {
namespace {

bool is_unit(FieldKind kind) {
  return kind == FieldKind::direction || kind == FieldKind::axis;
}

/// Mean of one field over all rows, weighted by `memberships`, into `out` (whose first values are
/// the representative's).
void average_field(const SampleMatrix& samples, std::span<const float> memberships,
                   const float* representative, const SampleField& field, int offset, float* out) {
  double sum[3] = {0, 0, 0};
  double total = 0;
  for (int row = 0; row < samples.rows; ++row) {
    if (!(memberships[row] > 0)) continue;
    const float* value = samples.row(row) + offset;
    double weight = memberships[row];
    total += weight;
    if (field.kind == FieldKind::axis) {
      double side = 0;
      for (int c = 0; c < field.width; ++c) side += double{value[c]} * representative[offset + c];
      if (side < 0) weight = -weight;
    }
    for (int c = 0; c < field.width; ++c) sum[c] += weight * value[c];
  }
  CHECK_MSG(total > 0, "a cluster of no members, of {} rows", samples.rows);
  if (is_unit(field.kind)) {
    const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    if (!(length > 1e-6 * total)) return;
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / length);
  } else {
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / total);
  }
}

/// Appends the record of one cluster.
void merge_cluster(const SampleMatrix& samples, std::span<const float> memberships,
                   int representative_row, float weight_per_sample, TypedRows& out) {
  const SampleType& type = *samples.type;
  const float* representative = samples.row(representative_row);
  const size_t start = out.values.size();
  out.values.insert(out.values.end(), representative, representative + type.width);
  for (size_t f = 0; f < type.field_count(); ++f) {
    if (type.merges[f] != Merge::average) continue;
    average_field(samples, memberships, representative, type.field(f), type.offsets[f],
                  &out.values[start + type.offsets[f]]);
  }
  const double members = std::accumulate(memberships.begin(), memberships.end(), 0.0);
  out.weights.push_back(static_cast<float>(weight_per_sample * members));
}

}  // namespace

void merge_clusters(const SampleMatrix& samples, const Clustering& clustering,
                    float weight_per_sample, TypedRows& out) {
  std::vector<float> memberships(samples.rows);
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    for (int row = 0; row < samples.rows; ++row) {
      memberships[row] = clustering.cluster_of[row] == cluster ? 1.0f : 0.0f;
    }
    merge_cluster(samples, memberships, clustering.representatives[cluster], weight_per_sample,
                  out);
  }
}

void merge_fuzzy_clusters(const SampleMatrix& samples, const FuzzyClustering& clustering,
                          float weight_per_sample, TypedRows& out) {
  std::vector<float> memberships(samples.rows);
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    for (int row = 0; row < samples.rows; ++row) {
      memberships[row] =
          clustering.memberships[static_cast<size_t>(row) * clustering.count() + cluster];
    }
    merge_cluster(samples, memberships, clustering.representatives[cluster], weight_per_sample,
                  out);
  }
}

void copy_rows(const SampleMatrix& samples, float weight_per_sample, TypedRows& out) {
  out.values.insert(out.values.end(), samples.values, samples.row(samples.rows));
  out.weights.insert(out.weights.end(), samples.rows, weight_per_sample);
}

}  // namespace relume

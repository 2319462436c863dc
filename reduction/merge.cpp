#include "reduction/merge.h"

#include <algorithm>

#include "core/base/check.h"

namespace relume {
namespace {

bool is_unit(FieldKind kind) { return kind == FieldKind::direction || kind == FieldKind::axis; }

/// Mean of one field over the rows of `cluster`, into `out` (its first values are the
/// representative's).
void average_field(const SampleMatrix& samples, const Clustering& clustering, int cluster,
                   const SampleField& field, int offset, float* out) {
  double sum[3] = {0, 0, 0};
  int members = 0;
  const float* representative = samples.row(clustering.representatives[cluster]) + offset;
  for (int row = 0; row < samples.rows; ++row) {
    if (clustering.cluster_of[row] != cluster) continue;
    const float* value = samples.row(row) + offset;
    double sign = 1;
    if (field.kind == FieldKind::axis) {
      double side = 0;
      for (int c = 0; c < field.width; ++c) side += double{value[c]} * representative[c];
      sign = side < 0 ? -1 : 1;
    }
    for (int c = 0; c < field.width; ++c) sum[c] += sign * value[c];
    ++members;
  }
  CHECK_MSG(members > 0, "cluster {} is empty", cluster);
  if (is_unit(field.kind)) {
    const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    if (!(length > 1e-6 * members)) return;
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / length);
  } else {
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / members);
  }
}

}  // namespace

void merge_clusters(const SampleMatrix& samples, const Clustering& clustering,
                    float weight_per_sample, TypedRows& out) {
  const SampleType& type = *samples.type;
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    const float* representative = samples.row(clustering.representatives[cluster]);
    const size_t start = out.values.size();
    out.values.insert(out.values.end(), representative, representative + type.width);
    for (size_t f = 0; f < type.field_count(); ++f) {
      if (type.merges[f] != Merge::average) continue;
      average_field(samples, clustering, cluster, type.field(f), type.offsets[f],
                    &out.values[start + type.offsets[f]]);
    }
    const auto members = std::count(clustering.cluster_of.begin(), clustering.cluster_of.end(),
                                    cluster);
    out.weights.push_back(weight_per_sample * static_cast<float>(members));
  }
}

void copy_rows(const SampleMatrix& samples, float weight_per_sample, TypedRows& out) {
  out.values.insert(out.values.end(), samples.values, samples.row(samples.rows));
  out.weights.insert(out.weights.end(), samples.rows, weight_per_sample);
}

}  // namespace relume

#include "reduction/merge.h"

#include <algorithm>
#include <span>

#include "core/base/check.h"
#include "reduction/footprints.h"

namespace relume {
namespace {

bool is_unit(FieldKind kind) {
  return kind == FieldKind::direction || kind == FieldKind::axis;
}

/// A row's share in a cluster.
struct Share {
  int row;
  double weight;  ///< > 0
};

/// Mean of one field over the members into `out` (whose first values are the representative's).
void average_field(const SampleMatrix& samples, std::span<const Share> members, double total,
                   const float* representative, const SampleField& field, int offset, float* out) {
  double sum[3] = {0, 0, 0};
  for (const Share& member : members) {
    const float* value = samples.row(member.row) + offset;
    double weight = member.weight;
    if (field.kind == FieldKind::axis) {
      double side = 0;
      for (int c = 0; c < field.width; ++c) side += double{value[c]} * representative[offset + c];
      if (side < 0) weight = -weight;
    }
    for (int c = 0; c < field.width; ++c) sum[c] += weight * value[c];
  }
  if (is_unit(field.kind)) {
    const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
    if (!(length > 1e-6 * total)) return;
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / length);
  } else {
    for (int c = 0; c < field.width; ++c) out[c] = static_cast<float>(sum[c] / total);
  }
}

/// Appends the footprint of the record that was appended last.
void add_footprint(const SampleMatrix& samples, std::span<const Share> members, int stored,
                   TypedRows& out) {
  const int normal = field_offset(*samples.type, FieldSource::normal);
  std::vector<PlacedSample> placed;
  placed.reserve(members.size());
  for (const Share& member : members) placed.push_back({samples.row(member.row), normal});
  const float* anchor = &out.values[out.values.size() - samples.type->width];
  append_footprint(placed, {anchor[0], anchor[1], anchor[2]}, stored, out);
}

/// Appends the record of one cluster.
void merge_cluster(const SampleMatrix& samples, std::span<const Share> members,
                   int representative_row, float weight_per_sample, TypedRows& out) {
  CHECK_MSG(!members.empty(), "a cluster of no members, of {} rows", samples.rows);
  const SampleType& type = *samples.type;
  const float* representative = samples.row(representative_row);
  double total = 0;
  for (const Share& member : members) total += member.weight;
  const size_t start = out.values.size();
  out.values.insert(out.values.end(), representative, representative + type.width);
  for (size_t f = 0; f < type.field_count(); ++f) {
    if (type.merges[f] != Merge::average) continue;
    average_field(samples, members, total, representative, type.field(f), type.offsets[f],
                  &out.values[start + type.offsets[f]]);
  }
  out.weights.push_back(static_cast<float>(weight_per_sample * total));
}

}  // namespace

void merge_clusters(const SampleMatrix& samples, const Clustering& clustering,
                    float weight_per_sample, TypedRows& out, int stored_members) {
  // Rows sorted by cluster: after the loop over rows, ends[c] is where cluster c ends.
  std::vector<Share> members(samples.rows);
  std::vector<int> ends(clustering.count() + 1, 0);
  for (const int cluster : clustering.cluster_of) ++ends[cluster + 1];
  for (int cluster = 0; cluster < clustering.count(); ++cluster) ends[cluster + 1] += ends[cluster];
  for (int row = 0; row < samples.rows; ++row) {
    members[ends[clustering.cluster_of[row]]++] = {row, 1.0};
  }
  int start = 0;
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    const int end = ends[cluster];
    const auto rows = std::span(members).subspan(start, end - start);
    merge_cluster(samples, rows, clustering.representatives[cluster], weight_per_sample, out);
    add_footprint(samples, rows, stored_members, out);
    start = end;
  }
}

void merge_fuzzy_clusters(const SampleMatrix& samples, const FuzzyClustering& clustering,
                          float weight_per_sample, TypedRows& out, int stored_members) {
  std::vector<Share> members;
  std::vector<Share> own;
  members.reserve(samples.rows);
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    members.clear();
    own.clear();
    for (int row = 0; row < samples.rows; ++row) {
      const float* shares = &clustering.memberships[static_cast<size_t>(row) * clustering.count()];
      const float share = shares[cluster];
      if (share > 0) members.push_back({row, share});
      if (std::max_element(shares, shares + clustering.count()) == shares + cluster) {
        own.push_back({row, share});
      }
    }
    merge_cluster(samples, members, clustering.representatives[cluster], weight_per_sample, out);
    add_footprint(samples, own, stored_members, out);
  }
}

void copy_rows(const SampleMatrix& samples, float weight_per_sample, TypedRows& out) {
  out.values.insert(out.values.end(), samples.values, samples.row(samples.rows));
  out.weights.insert(out.weights.end(), samples.rows, weight_per_sample);
  out.footprints.insert(out.footprints.end(), samples.rows, Footprint());
}

}  // namespace relume

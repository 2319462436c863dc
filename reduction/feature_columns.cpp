#include "reduction/feature_columns.h"

#include "core/simd/row_kernels.h"

namespace relume {

void make_feature_columns(const Features& features, FeatureColumns& columns) {
  const int stride = (features.rows + row_lanes - 1) / row_lanes * row_lanes;
  columns.rows = features.rows;
  columns.dimensions = features.dimensions;
  columns.stride = stride;
  columns.values.assign(static_cast<size_t>(stride) * features.dimensions, 0.0f);
  for (int row = 0; row < features.rows; ++row) {
    const float* values = features.row(row);
    float* out = &columns.values[row];
    for (int i = 0; i < features.dimensions; ++i) out[static_cast<size_t>(i) * stride] = values[i];
  }
}

void eval_distances(const FeatureColumns& columns, const float* points, int count,
                    float* distances) {
  best_row_kernels().distances(columns.values.data(), columns.dimensions, columns.stride, points,
                               count, distances);
}

void make_pair_distances(const Features& features, FeatureColumns& columns, PairDistances& pairs) {
  make_feature_columns(features, columns);
  pairs.rows = columns.rows;
  pairs.stride = columns.stride;
  pairs.values.resize(static_cast<size_t>(columns.rows) * columns.stride);
  eval_distances(columns, features.values.data(), features.rows, pairs.values.data());
}

}  // namespace relume

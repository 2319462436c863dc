#pragma once

#include "reduction/features.h"

namespace relume {

/// Features turned on their side, coordinate by coordinate with the rows next to each other, for
/// the loops over rows in core/simd/row_kernels.h.
struct FeatureColumns {
  std::vector<float> values;  ///< dimensions x stride; padding is 0
  int rows = 0;
  int dimensions = 0;
  int stride = 0;  ///< rows, padded to a multiple of row_lanes
};

void make_feature_columns(const Features& features, FeatureColumns& columns);

/// Squared Euclidean distances of all rows from each of `count` points of `dimensions` floats into
/// `distances` (count x stride floats; those of the padding are of no use). Coordinates are summed
/// in order. Does not allocate.
void eval_distances(const FeatureColumns& columns, const float* points, int count,
                    float* distances);

/// Squared distances of all pairs of rows.
struct PairDistances {
  std::vector<float> values;  ///< rows x stride, symmetric, 0 on the diagonal
  int rows = 0;
  int stride = 0;  ///< rows, padded to a multiple of row_lanes; padding is of no use

  const float* row(int i) const { return &values[static_cast<size_t>(i) * stride]; }
};

/// O(rows^2 dimensions). `columns` becomes the features' own.
void make_pair_distances(const Features& features, FeatureColumns& columns, PairDistances& pairs);

}  // namespace relume

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/samples/sample_type.h"

namespace relume {

/// A pixel's samples of one type as a plain matrix: rows x type->width floats, row by row, in
/// sampling order. A view; needs no scene.
struct SampleMatrix {
  const SampleType* type = nullptr;
  const float* values = nullptr;
  int rows = 0;

  const float* row(int i) const { return values + static_cast<size_t>(i) * type->width; }
};

/// A partition of the rows of one SampleMatrix.
struct Clustering {
  std::vector<int> cluster_of;       ///< per row, in [0, count)
  std::vector<int> representatives;  ///< per cluster, the row whose representative fields it takes

  int count() const { return static_cast<int>(representatives.size()); }
};

/// Rows shared among clusters: row i belongs to cluster c with weight memberships[i * count() + c],
/// >= 0; a row's memberships sum to 1.
struct FuzzyClustering {
  std::vector<float> memberships;
  std::vector<int> representatives;  ///< as in Clustering

  int count() const { return static_cast<int>(representatives.size()); }
};

}  // namespace relume

#pragma once

#include "reduction/sample_matrix.h"

namespace relume {

/// A matrix of clustering coordinates: rows x dimensions floats.
struct Features {
  std::vector<float> values;
  int rows = 0;
  int dimensions = 0;

  const float* row(int i) const { return &values[static_cast<size_t>(i) * dimensions]; }
};

/// The report's parameter space (sec. 3.1): every field as it is, concatenated, in raw units, so
/// that large numbers such as exponents dominate. Only the shadow-ray bias, which is ours, is left
/// out. The mean row is subtracted, in double: distances stay the same and keep their precision far
/// from the origin.
void make_raw_features(const SampleMatrix& samples, Features& features);

/// Scaled coordinates in which unit distance means about the same visual change: positions over the
/// scene's radius, directions as they are, axes turned to one side, colours times 2, exponents as
/// 0.3 ln(1 + x). Independent of the scene's units.
void make_scaled_features(const SampleMatrix& samples, float scene_radius, Features& features);

}  // namespace relume

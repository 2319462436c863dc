#pragma once

#include <vector>

#include "core/shade/light_matrix.h"
#include "reduction/sample_matrix.h"

namespace relume {

/// What one pixel's samples look like under the training lights. Buffers are kept between pixels.
struct PixelResponses {
  int columns = 0;                        ///< lights, padded: see LightSet
  std::vector<std::vector<float>> lobes;  ///< per type: rows x max_lobes x columns
  std::vector<std::vector<float>> v;      ///< per type: rows x 3 x columns, the matrix V
  /// 3 x columns: the pixel's own value, (1 / s) sum over its s samples of V; misses are black.
  std::vector<float> target;
};

/// Fills `responses` for the samples of one pixel, a matrix a type, each sample of weight
/// `weight_per_sample` (1 / s). Unshadowed.
void evaluate_responses(const LobeEvaluator& evaluator, std::span<const SampleMatrix> matrices,
                        float weight_per_sample, PixelResponses& responses);

/// target = weight_per_sample times the sum of all rows of V: again, after V was changed.
void sum_target(std::span<const SampleMatrix> matrices, float weight_per_sample,
                PixelResponses& responses);

}  // namespace relume

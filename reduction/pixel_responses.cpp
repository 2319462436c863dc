#include "reduction/pixel_responses.h"

namespace relume {

void evaluate_responses(const LobeEvaluator& evaluator, std::span<const SampleMatrix> matrices,
                        float weight_per_sample, PixelResponses& responses) {
  const int columns = evaluator.lights().columns();
  responses.columns = columns;
  responses.lobes.resize(matrices.size());
  responses.v.resize(matrices.size());
  for (size_t t = 0; t < matrices.size(); ++t) {
    const SampleMatrix& matrix = matrices[t];
    const int type = static_cast<int>(t);
    responses.lobes[t].resize(static_cast<size_t>(matrix.rows) * max_lobes * columns);
    responses.v[t].resize(static_cast<size_t>(matrix.rows) * 3 * columns);
    for (int row = 0; row < matrix.rows; ++row) {
      evaluator.lobes(type, matrix.row(row),
                      &responses.lobes[t][static_cast<size_t>(row) * max_lobes * columns]);
    }
    shade_rows(evaluator, type, matrix.values, matrix.rows, responses.lobes[t].data(),
               responses.v[t].data());
  }
  sum_target(matrices, weight_per_sample, responses);
}

void sum_target(std::span<const SampleMatrix> matrices, float weight_per_sample,
                PixelResponses& responses) {
  const int length = 3 * responses.columns;
  responses.target.assign(length, 0.0f);
  for (size_t t = 0; t < matrices.size(); ++t) {
    for (int row = 0; row < matrices[t].rows; ++row) {
      const float* v = &responses.v[t][static_cast<size_t>(row) * length];
      for (int i = 0; i < length; ++i) responses.target[i] += weight_per_sample * v[i];
    }
  }
}

}  // namespace relume

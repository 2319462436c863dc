#pragma once

#include "core/base/random.h"
#include "core/samples/sample_tile.h"
#include "reduction/pixel_responses.h"

namespace relume {

/// Light-Fit, ours: clusters a pixel's samples across types by what they look like under training
/// lights, gives each cluster one record whose colours, direction and exponent are *fitted* to the
/// cluster's summed response, and polishes all records together on TR2007-600 eq. 2. Where the
/// report picks or averages samples, this solves for the record.
struct LightFitParams {
  int records = 8;                ///< k, >= 1
  bool joint = true;              ///< polish all records together ("full"); false is "fast"
  int restarts = 4;               ///< of the clustering
  int cluster_steps = 4;          ///< Levenberg-Marquardt steps per cluster
  int joint_steps = 8;            ///< and together
  float position_weight = 0.02f;  ///< of position and direction against response, in clustering
  /// Weight of "each record stands for its own cluster", sum_r |f_r - t_r|^2: with visibility v
  /// plus independent noise per cluster the expected error of the sum takes this form, rho = var /
  /// E[v]^2.
  float rho = 0.1f;
  /// Weight of the prior that pulls colours to the cluster's own sums, in units of each lobe's
  /// energy: without it a highlight that no training light hits leaves its colour free.
  float mu = 0.01f;
};

/// One pixel's records: their vectors by type, ready to be appended.
struct FittedRecord {
  int type = 0;
  float weight = 0;  ///< sum of its members' weights
  std::vector<float> vector;
};

/// Fits the records of one pixel. `matrices` are its samples by type (at least records + 1 in all),
/// each of weight `weight_per_sample`; `responses` as evaluate_responses fills them for the same
/// evaluator. Empty when the method does not apply: a type without a fitted direction or colours,
/// or all responses black. Anchors (position, bias) are always one member's. Deterministic.
std::vector<FittedRecord> light_fit(const LobeEvaluator& evaluator,
                                    std::span<const SampleMatrix> matrices, float weight_per_sample,
                                    const PixelResponses& responses, const LightFitParams& params,
                                    Random& random);

/// Mean over the evaluator's lights and RGB of the squared difference between the summed response
/// of `records` and `target` (3 x columns), eq. 2: for the guard and for error prediction.
double response_error(const LobeEvaluator& evaluator, std::span<const FittedRecord> records,
                      std::span<const float> target);

}  // namespace relume

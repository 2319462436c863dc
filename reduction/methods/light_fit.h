#pragma once

#include "core/base/random.h"
#include "reduction/footprints.h"
#include "reduction/methods/light_fit_pixel.h"

namespace relume {

/// Light-Fit, ours: clusters a pixel's samples across types by what they look like under training
/// lights, gives each cluster one record whose colours, direction and exponent are *fitted* to the
/// cluster's summed response, and polishes all records together on TR2007-600 eq. 2. Where the
/// report picks or averages samples, this solves for the record.
struct LightFitParams {
  bool joint = true;              ///< polish all records together ("full"); false is "fast"
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

/// One fitted record: its vector, ready to be appended to the rows of its type.
struct FittedRecord {
  int type = 0;
  float weight = 0;  ///< sum of its members' weights
  std::vector<float> vector;
  std::vector<PlacedSample> members;  ///< whatever their types; point into the loaded samples
};

/// Fits the records of one pixel after the other: load() one, then fit() for any k. Buffers are
/// kept; one object a thread.
class LightFit {
 public:
  /// `evaluator` must outlive the object.
  LightFit(const LobeEvaluator& evaluator, const LightFitParams& params);

  /// True when records of this type can be fitted: it declares a direction and colours . Others are
  /// reduced by the report's categories.
  bool fits_type(int type) const { return is_fitted_[type]; }

  /// Evaluates the samples of one pixel, by type, each of weight `weight_per_sample`. Types that do
  /// not fit are left out; the others' values must stay until the last fit(). False when there is
  /// nothing to fit: no samples, or all responses black or not finite.
  bool load(std::span<const SampleMatrix> matrices, float weight_per_sample);

  /// Samples of the loaded pixel that are of fitted types.
  int sample_count() const { return pixel_.n(); }

  /// At most k records, 1 <= k < sample_count(). Empty when a value is not finite. Anchors
  /// (position, bias) are always one member's. Deterministic.
  std::vector<FittedRecord> fit(int k);

 private:
  const LobeEvaluator& evaluator_;
  LightFitParams params_;
  std::vector<bool> is_fitted_;  ///< per type
  FitPixel pixel_;
  MedoidCosts unexplained_;
};

}  // namespace relume

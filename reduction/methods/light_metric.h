#pragma once

#include "core/math/vec.h"
#include "reduction/reduction.h"
#include "reduction/representatives.h"
#include "reduction/training.h"

namespace relume {

/// TR2007-600's Light Metrics 1 to 6, one pixel at a time: prepare() for the pixel, then cluster()
/// for each of its types. Buffers are kept between pixels; one object a thread.
///
/// | method | representatives | clusters |
/// | --- | --- | --- |
/// | 1 | least eq. 4 | nearest representative, raw fields |
/// | 2 | least eq. 4 within shader groups drawn by eq. 5 | the same |
/// | 3 | as 2; then each cluster's member of least eq. 4 as a white Lambert without shadows | as 2
/// | | 4 | greedy eq. 6 | as 1 | | 5 | nearest the centroid | k-means on rows of V | | 6 | each
/// cluster's member of least eq. 4 | k-means on raw fields |
///
/// White Lambert, for any shader: its first lobe, which is the diffuse one, with colour 1; on
/// strands that is Kajiya and Kay's, on leaves the reflecting side. K-means means the report's,
/// from the first k samples.
class LightMetric {
 public:
  explicit LightMetric(const TrainingSet& training) : training_(training) {}

  /// Evaluates the samples of one pixel under the training lights. `weight_per_sample` is 1 / s.
  void prepare(ReductionMethod method, std::span<const SampleMatrix> matrices,
               float weight_per_sample);

  /// Clusters type `type` of the prepared pixel into at most k clusters, 1 <= k < rows. `random` is
  /// used by methods 2 and 3.
  Clustering cluster(int type, int k, const ReductionParams& params, Random& random);

 private:
  ValueRows rows(int type) const;
  void find_mean_colors();
  void find_white_values(float weight_per_sample);
  Clustering cluster_around(int type, std::span<const int> representatives);
  Clustering cluster_by_groups(int type, int k, Random& random);

  const TrainingSet& training_;
  ReductionMethod method_ = ReductionMethod::light_metric_1;
  std::vector<SampleMatrix> matrices_;
  PixelResponses responses_;
  std::vector<std::vector<vec3>> mean_colors_;  ///< per type and row, over all lights
  std::vector<std::vector<float>> white_;       ///< per type: rows x columns, as a white Lambert
  std::vector<float> white_target_;             ///< columns: the pixel's mean of those
  std::vector<float> errors_;
  Features features_;
};

}  // namespace relume

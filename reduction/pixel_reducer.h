#pragma once

#include <optional>

#include "core/samples/sample_tile.h"
#include "reduction/budget.h"
#include "reduction/methods/kmeans.h"
#include "reduction/methods/light_fit.h"
#include "reduction/methods/light_metric.h"
#include "reduction/reduction.h"

namespace relume {

/// The records of one pixel, by type; `first` is not used.
using PixelRecords = std::vector<TypedRows>;

/// Reduces pixels one after the other: load() one, then ask for its records at any k. Buffers are
/// kept between pixels; one object a thread.
class PixelReducer {
 public:
  /// `params` and what `lights` points to must outlive the reducer. `all` and `pure` do not reduce
  /// and are refused.
  PixelReducer(std::span<const SampleType> types, const ReductionParams& params,
               const ReductionLights& lights);

  /// Makes pixel `index` of `tile`, number `pixel` of the image, the current one. `tile` must stay.
  void load(const SampleTile& tile, int index, uint64_t pixel);

  int sample_count() const { return sample_count_; }
  /// The sum of its samples' weights: its coverage, [0, 1].
  float coverage() const { return coverage_; }

  /// At most k records, k >= 1, in `records`; all its samples when k >= sample_count(). Returns
  /// what they change, predicted: the mean over the validation lights of TR2007-600 eq. 7's RMS
  /// over RGB, unshadowed; 0 when needs_validation() does not hold.
  float reduce(int k, PixelRecords& records);

  /// The pixel's error at the steps of record_steps up to params.records, as far as one of them can
  /// still be chosen when a record costs `cost`. At 0 records the error is the pixel itself.
  ErrorCurve error_curve(float cost);

  /// The records that error_curve(params.record_cost) makes worth their place; returns their
  /// predicted error.
  float reduce_within_cost(PixelRecords& records);

 private:
  void train();
  void try_steps(float cost, ErrorCurve& curve, PixelRecords* best);
  void reduce_type(size_t type, int k, float weight, Random& random, TypedRows& records);
  float predicted_error(const PixelRecords& records);
  float fit(const std::vector<int>& allocation, PixelRecords& records, float error);
  Random make_random(size_t type) const;
  const std::vector<float>& target();
  void add_values(const SampleType& type, int type_index, const float* vectors,
                  const float* weights, size_t rows, std::vector<float>& sum);

  std::span<const SampleType> types_;
  const ReductionParams& params_;
  ReductionLights lights_;
  std::optional<LightMetric> light_metric_;
  std::optional<LightFit> light_fit_;

  uint64_t pixel_ = 0;
  std::vector<SampleMatrix> matrices_;
  std::vector<int> counts_;  ///< samples per type
  int sample_count_ = 0;
  float coverage_ = 0;
  bool trained_ = false;  ///< light_metric_ or light_fit_ has seen the pixel
  bool fit_applies_ = false;
  bool target_ready_ = false;
  std::vector<float> target_;  ///< 3 x columns: the pixel under the validation lights
  PixelRecords trial_;
  Features features_;
  KmeansBuffers kmeans_;
  std::vector<int> first_k_;
  std::vector<float> lobes_;
  std::vector<float> values_;
  std::vector<float> weights_;
  std::vector<float> sum_;
};

}  // namespace relume

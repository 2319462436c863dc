#pragma once

#include "core/samples/sample_tile.h"
#include "reduction/methods/light_fit.h"
#include "reduction/training.h"

namespace relume {

/// Light-Fit pixel by pixel, with buffers kept between pixels, and its guard: of the fitted records
/// and those of strong k-means the ones with the smaller eq. 2 error on validation lights, which
/// the fit has not seen, are taken. So Light-Fit is never worse than strong k-means on them.
class LightFitReducer {
 public:
  /// `training` holds both sets of lights and must outlive the reducer.
  LightFitReducer(const TrainingSet& training, const LightFitParams& params);

  /// Appends the records of one pixel. `guard` are strong k-means' records, by type.
  void reduce(std::span<const SampleMatrix> matrices, float weight_per_sample,
              std::span<const TypedRows> guard, Random& random, SampleTile& records);

 private:
  const TrainingSet& training_;
  LightFitParams params_;
  PixelResponses responses_;
};

}  // namespace relume

#pragma once

#include <memory>
#include <vector>

#include "core/samples/sample_scene.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "shadow/traced.h"

namespace relume {

/// Training lights with what shadows them. Const use is thread-safe.
struct Training {
  TrainingSet set;
  /// Owns what set.visibility points to, one per light that casts a shadow; keeps references to the
  /// view's tracer, which must outlive it.
  std::vector<std::unique_ptr<TracedVisibility>> shadows;
};

/// Light-Fit's own lights: 64 to fit and 32 others as set.validation, both evenly spread
/// (make_mixed_training_lights) and without shadows, for the types, the eye and the bounds of
/// `view`. Uses `reduction.seed` and `reduction.scene_radius` (world units, > 0).
std::unique_ptr<const Training> make_fit_training(const Scene& scene, const ViewSampler& view,
                                                  const ReductionParams& reduction);

/// What `reduction.method` is trained on: make_fit_training() for Light-Fit, which takes nothing
/// from `params`; lights between the scene's representative ones after `params` for Light Metrics;
/// null for methods that need none.
std::unique_ptr<const Training> make_training(const Scene& scene, const ViewSampler& view,
                                              const ReductionParams& reduction,
                                              const TrainingParams& params);

}  // namespace relume

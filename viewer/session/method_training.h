#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/samples/sample_scene.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "shadow/traced.h"

namespace relume {

/// The lights that a reduction is trained on and judged by, with what shadows them. Const use is
/// thread-safe.
struct MethodLights {
  std::optional<TrainingSet> training;    ///< for methods that need it
  std::optional<TrainingSet> validation;  ///< when needs_validation(reduction)
  /// Owns what training->visibility points to, one per light that casts a shadow; keeps references
  /// to the view's tracer, which must outlive it.
  std::vector<std::unique_ptr<TracedVisibility>> shadows;

  ReductionLights lights() const {
    return {training ? &*training : nullptr, validation ? &*validation : nullptr};
  }
};

/// What `reduction` is trained on, for the types, the eye and the bounds of `view`: 128 evenly
/// spread lights without shadows for Light-Fit (make_mixed_training_lights), which takes nothing
/// from `params`; lights between the scene's representative ones after `params` for Light Metrics;
/// none for other methods. Validation lights are 40 more of the even ones. Uses `reduction.seed`
/// and `reduction.scene_radius` (world units, > 0).
std::unique_ptr<const MethodLights> make_method_lights(const Scene& scene, const ViewSampler& view,
                                                       const ReductionParams& reduction,
                                                       const TrainingParams& params);

}  // namespace relume

#pragma once

#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/trace/tracer.h"
#include "viewer/study/trial_log.h"

namespace relume {

/// One thing about a scene, taken to an extreme.
enum class Extreme {
  scale,      ///< of everything, lights included: the picture stays the same
  distance,   ///< of the lights from the scene's centre, in scene radii, as bright as before
  exponent,   ///< of all materials that have one
  intensity,  ///< of the lights, a factor
  thinness,   ///< of strands: their radius, a factor
};

inline constexpr std::array extreme_labels = {
    Label<Extreme>{Extreme::scale, "scale"},       Label<Extreme>{Extreme::distance, "distance"},
    Label<Extreme>{Extreme::exponent, "exponent"}, Label<Extreme>{Extreme::intensity, "intensity"},
    Label<Extreme>{Extreme::thinness, "thinness"},
};

struct StabilityParams {
  int spp = 25;     ///< samples per pixel
  int records = 4;  ///< k of the reduction whose error is measured
  int width = 128;  ///< pixels
  int height = 128;
  uint64_t seed = 0;
};

/// What one extreme does to a picture without shadows and to its shadow rays.
struct StabilityFigure {
  Extreme extreme = Extreme::scale;
  double value = 1;
  int64_t covered_pixels = 0;
  double error_relative = 0;  ///< kernels against the double reference, same samples: eq. 7 / mean
  double error_max = 0;       ///< largest of a pixel, of its value or of 1e-3 of the mean
  double error_reduced = 0;   ///< strong K-means at `records` against all samples: eq. 7 / mean
  double visibility = 0;      ///< mean over covered pixels and lights, one ray a sample
  int64_t replaced_values = 0;    ///< not finite, replaced by 0
  int64_t non_finite_values = 0;  ///< left in the picture
};

/// A copy of `scene` with one thing taken to an extreme. `bounds` of the scene, world.
Scene make_extreme_scene(const Scene& scene, const Bounds& bounds, Extreme extreme, double value);

/// Every extreme that the scene has something for, several values of each. Deterministic. Figures
/// that `log` holds are taken from it, the others added. The scene's materials emit nothing (see
/// remove_emission).
std::vector<StabilityFigure> study_stability(const Scene& scene, const Tracer& tracer,
                                             const StabilityParams& params, TrialLog& log,
                                             const ProgressCallback& progress);

}  // namespace relume

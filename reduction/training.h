#pragma once

#include <memory>

#include "core/math/vec.h"
#include "core/relight/visibility.h"
#include "reduction/pixel_responses.h"

namespace relume {

/// The lights that light-based methods are trained on.
struct TrainingParams {
  int lights = 200;      ///< l, TR2007-600 sec. 4.2; [1, 4096]
  bool shadows = false;  ///< V holds shadowed values, as the report's did (sec. 4.4)
  uint64_t seed = 0;
};

/// The report's: 200 lights, with shadows. The report says so only in passing ("noise introduced by
/// each random light from shadows"); its verdict on Light Metric 5 agrees (docs/reduction.md).
TrainingParams report_faithful_training();

/// Training lights, ready to evaluate samples under. Movable; const use is thread-safe.
struct TrainingSet {
  std::unique_ptr<const LightSet> lights;
  LobeEvaluator evaluator;  ///< over *lights
  /// Per column of *lights, prepared for lights->lights[column]: what shadows it. Null: no shadow.
  /// An empty vector: none anywhere. Not owned; columns of padding may be null.
  std::vector<const VisibilitySource*> visibility;
};

/// l lights, each a random interpolation between the scene's two representative lights, every
/// parameter by itself (a box, not a segment; TR2007-600 sec. 3.2). Never the same as test lights,
/// which take low indices: see first_training_light.
std::vector<Light> make_training_lights(const Light& low, const Light& high,
                                        const TrainingParams& params);

/// Training lights are interpolate_light(low, high, seed, first_training_light + i), so that any
/// light of a lower index is held out.
inline constexpr uint64_t first_training_light = uint64_t{1} << 32;

/// `count` lights spread evenly instead of randomly, for fitting (ours, not the report's): the
/// first three quarters, rounded up, between the representatives, position and direction by the
/// Halton sequence and the rest as interpolate_light; the others directional, from all sides of the
/// sphere, as bright at the centre of `scene` as the first ones are on average, so that a light
/// that leaves the representatives' box finds no surprise. `seed` shifts both sequences.
std::vector<Light> make_mixed_training_lights(const Light& low, const Light& high,
                                              const Bounds& scene, int count, uint64_t seed);

/// Without visibility. `types` of the scene, `eye` in world space, `scene_radius` in world units.
TrainingSet make_training_set(std::span<const Light> lights, std::span<const SampleType> types,
                              vec3 eye, float scene_radius);

/// evaluate_responses, then V and target times the visibility of each sample from each light. Lobes
/// stay unshadowed. Buffers in `responses` are kept between pixels.
void evaluate_training(const TrainingSet& training, std::span<const SampleMatrix> matrices,
                       float weight_per_sample, PixelResponses& responses);

}  // namespace relume

#include "viewer/session/method_training.h"

namespace relume {
namespace {

constexpr int fit_lights = 64;
constexpr int validation_lights = 32;

}  // namespace

std::unique_ptr<const Training> make_fit_training(const Scene& scene, const ViewSampler& view,
                                                  const ReductionParams& reduction) {
  const auto make_set = [&](int count, uint64_t seed) {
    return make_training_set(
        make_mixed_training_lights(scene.representative_low, scene.representative_high,
                                   view.tracer->bounds(), count, seed),
        view.types.types, view.rays.eye(), reduction.scene_radius);
  };
  auto training = std::make_unique<Training>(make_set(fit_lights, reduction.seed));
  training->set.validation =
      std::make_unique<TrainingSet>(make_set(validation_lights, reduction.seed + 1));
  return training;
}

std::unique_ptr<const Training> make_training(const Scene& scene, const ViewSampler& view,
                                              const ReductionParams& reduction,
                                              const TrainingParams& params) {
  if (!needs_training(reduction.method)) return nullptr;
  if (needs_validation(reduction.method)) return make_fit_training(scene, view, reduction);
  const std::vector<Light> lights =
      make_training_lights(scene.representative_low, scene.representative_high, params);
  auto training = std::make_unique<Training>(
      make_training_set(lights, view.types.types, view.rays.eye(), reduction.scene_radius));
  if (!params.shadows) return training;
  for (const Light& light : training->set.lights->lights) {
    if (light.casts_shadow) {
      training->shadows.push_back(std::make_unique<TracedVisibility>(*view.tracer));
      training->shadows.back()->prepare(light);
    }
    training->set.visibility.push_back(light.casts_shadow ? training->shadows.back().get()
                                                          : nullptr);
  }
  return training;
}

}  // namespace relume

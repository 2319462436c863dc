#include "viewer/session/method_training.h"

namespace relume {
namespace {

constexpr int fit_lights = 128;
constexpr int validation_lights = 40;  // with its padding as many columns as 32

void add_shadows(const Tracer& tracer, MethodLights& lights) {
  for (const Light& light : lights.training->lights->lights) {
    if (light.casts_shadow) {
      lights.shadows.push_back(std::make_unique<TracedVisibility>(tracer));
      lights.shadows.back()->prepare(light);
    }
    lights.training->visibility.push_back(light.casts_shadow ? lights.shadows.back().get()
                                                             : nullptr);
  }
}

}  // namespace

std::unique_ptr<const MethodLights> make_method_lights(const Scene& scene, const ViewSampler& view,
                                                       const ReductionParams& reduction,
                                                       const TrainingParams& params) {
  const Light& low = scene.representative_low;
  const Light& high = scene.representative_high;
  const auto make_set = [&](const std::vector<Light>& lights) {
    return make_training_set(lights, view.types.types, view.rays.eye(), reduction.scene_radius);
  };
  const auto make_even_set = [&](int count, uint64_t seed) {
    return make_set(make_mixed_training_lights(low, high, view.tracer->bounds(), count, seed));
  };
  auto lights = std::make_unique<MethodLights>();
  if (needs_validation(reduction)) {
    lights->validation = make_even_set(validation_lights, reduction.seed + 1);
  }
  if (is_light_fit(reduction.method)) {
    lights->training = make_even_set(fit_lights, reduction.seed);
  } else if (needs_training(reduction.method)) {
    lights->training = make_set(make_training_lights(low, high, params));
    if (params.shadows) add_shadows(*view.tracer, *lights);
  }
  return lights;
}

}  // namespace relume

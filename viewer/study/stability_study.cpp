#include "viewer/study/stability_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/image/metrics.h"
#include "core/relight/pixel_visibility.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "shadow/traced.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

struct ExtremeCase {
  Extreme extreme;
  double value;
};

constexpr ExtremeCase cases[] = {
    {Extreme::scale, 1e-6},     {Extreme::scale, 1e-3},    {Extreme::scale, 1},
    {Extreme::scale, 1e3},      {Extreme::scale, 1e6},     {Extreme::distance, 1e-3},
    {Extreme::distance, 1},     {Extreme::distance, 1e3},  {Extreme::distance, 1e6},
    {Extreme::exponent, 0},     {Extreme::exponent, 1},    {Extreme::exponent, 100},
    {Extreme::exponent, 1e4},   {Extreme::exponent, 1e5},  {Extreme::intensity, 1e-30},
    {Extreme::intensity, 1e-6}, {Extreme::intensity, 1e6}, {Extreme::intensity, 1e15},
    {Extreme::thinness, 1e-1},  {Extreme::thinness, 1e-2}, {Extreme::thinness, 1e-3},
};

void scale_light(Light& light, float factor) {
  light.position *= factor;
  if (light.falloff && light.type != LightType::directional) light.gain *= factor * factor;
}

void scale_scene(Scene& scene, float factor) {
  for (Instance& instance : scene.instances) {
    for (int column = 0; column < 4; ++column) instance.world_from_local[column] *= factor;
  }
  scene.camera.eye *= factor;
  scene.camera.target *= factor;
  for (Light& light : scene.lights) scale_light(light, factor);
  scale_light(scene.representative_low, factor);
  scale_light(scene.representative_high, factor);
}

void place_lights(Scene& scene, const Bounds& bounds, float distance) {
  for (Light& light : scene.lights) {
    const vec3 offset = light.position - bounds.center();
    const float before = glm::length(offset);
    const float after = distance * bounds.radius();
    light.position = bounds.center() + after * normalize_or(offset, {0, 1, 0});
    // Brightness far away follows the distance; near by it is limited as the kernels limit it.
    const float ratio = after / std::max(before, 1e-3f * bounds.radius());
    if (light.falloff && ratio > 1) light.gain *= ratio * ratio;
  }
}

bool has_exponent(const Scene& scene, const Material& material) {
  return std::ranges::any_of(scene.shaders[material.shader]->fields,
                             [](const SampleField& field) { return field.name == "exponent"; });
}

void set_exponents(Scene& scene, float exponent) {
  for (Material& material : scene.materials) {
    if (!has_exponent(scene, material)) continue;
    std::erase_if(material.parameters, [](const auto& p) { return p.name == "exponent"; });
    material.parameters.push_back({"exponent", vec3(exponent), -1});
  }
}

void thin_strands(Scene& scene, float factor) {
  for (Prototype& prototype : scene.prototypes) {
    for (auto& shape : prototype.shapes) {
      Curves* curves = std::get_if<Curves>(&shape);
      if (curves == nullptr) continue;
      for (vec4& point : curves->points) point.w *= factor;
    }
  }
}

bool applies(const Scene& scene, Extreme extreme) {
  if (extreme == Extreme::exponent) {
    return std::ranges::any_of(scene.materials,
                               [&](const Material& m) { return has_exponent(scene, m); });
  }
  return extreme != Extreme::thinness || count_scene(scene).strands > 0;
}

RelightCache prepare_case(const Scene& scene, const Tracer& tracer, const StabilityParams& study,
                          ReductionMethod method) {
  PrepareParams params;
  params.spp = study.spp;
  params.reduction.method = method;
  params.reduction.records = study.records;
  params.reduction.seed = study.seed;
  params.width = study.width;
  params.height = study.height;
  return prepare_in_memory(scene, tracer, params, {});
}

Image add_reference_layers(const RelightCache& cache) {
  const CacheInfo& info = cache.info();
  std::vector<double> sums(static_cast<size_t>(info.width) * info.height * 3, 0.0);
  for (const Light& light : info.lights) {
    const Image layer = reference_layer(cache, light, nullptr);
    const vec3 weight = light.weight();
    for (size_t i = 0; i < sums.size(); ++i) {
      sums[i] += double{layer.pixels[i]} * weight[static_cast<int>(i % 3)];
    }
  }
  Image image(info.width, info.height);
  std::ranges::transform(sums, image.pixels.begin(),
                         [](double v) { return static_cast<float>(v); });
  return image;
}

double largest_relative_error(const Image& image, const Image& reference, double mean) {
  double largest = 0;
  for (size_t i = 0; i < reference.pixels.size(); ++i) {
    const double expected = reference.pixels[i];
    const double scale = std::max(std::abs(expected), 1e-3 * mean);
    if (scale > 0) largest = std::max(largest, std::abs(image.pixels[i] - expected) / scale);
  }
  return largest;
}

double mean_visibility(const RelightCache& cache, const Tracer& tracer,
                       const std::vector<float>& coverage) {
  TracedVisibility source(tracer);
  double sum = 0;
  for (const Light& light : cache.info().lights) {
    source.prepare(light);
    sum += mean_covered(pixel_visibility(cache, source), coverage);
  }
  return sum / static_cast<double>(std::max<size_t>(1, cache.info().lights.size()));
}

double over(double value, double mean) {
  return mean > 0 ? value / mean : 0;
}

StabilityFigure measure_case(const Scene& scene, const Bounds& bounds, const ExtremeCase& extreme,
                             const StabilityParams& params) {
  const Scene changed = make_extreme_scene(scene, bounds, extreme.extreme, extreme.value);
  const Tracer tracer(changed);
  const RelightCache all = prepare_case(changed, tracer, params, ReductionMethod::all);
  const RelightCache few = prepare_case(changed, tracer, params, ReductionMethod::strong_kmeans);
  const std::vector<float> coverage = all.coverage();
  RelightState state = make_relight_state(all);
  const RelightStats stats = relight(state, all.info().lights, nullptr);
  RelightState reduced = make_relight_state(few);
  relight(reduced, all.info().lights, nullptr);
  const Image reference = add_reference_layers(all);
  const ImageError error = compare_images(state.frame, reference, coverage);
  const ImageError reduction = compare_images(reduced.frame, state.frame, coverage);
  StabilityFigure figure;
  figure.covered_pixels = static_cast<int64_t>(error.covered_pixels);
  figure.error_relative = over(error.error_covered, error.reference_mean);
  figure.error_max = largest_relative_error(state.frame, reference, error.reference_mean);
  figure.error_reduced = over(reduction.error_covered, reduction.reference_mean);
  figure.visibility = mean_visibility(all, tracer, coverage);
  figure.replaced_values = static_cast<int64_t>(stats.replaced_values);
  figure.non_finite_values =
      std::ranges::count_if(state.frame.pixels, [](float value) { return !std::isfinite(value); });
  return figure;
}

std::vector<double> to_values(const StabilityFigure& f) {
  return {static_cast<double>(f.covered_pixels),
          f.error_relative,
          f.error_max,
          f.error_reduced,
          f.visibility,
          static_cast<double>(f.replaced_values),
          static_cast<double>(f.non_finite_values)};
}

StabilityFigure from_values(const std::vector<double>& values) {
  StabilityFigure figure;
  figure.covered_pixels = static_cast<int64_t>(values.at(0));
  figure.error_relative = values.at(1);
  figure.error_max = values.at(2);
  figure.error_reduced = values.at(3);
  figure.visibility = values.at(4);
  figure.replaced_values = static_cast<int64_t>(values.at(5));
  figure.non_finite_values = static_cast<int64_t>(values.at(6));
  return figure;
}

}  // namespace

Scene make_extreme_scene(const Scene& scene, const Bounds& bounds, Extreme extreme, double value) {
  Scene changed = scene;
  const auto factor = static_cast<float>(value);
  switch (extreme) {
    case Extreme::scale:
      scale_scene(changed, factor);
      break;
    case Extreme::distance:
      place_lights(changed, bounds, factor);
      break;
    case Extreme::exponent:
      set_exponents(changed, factor);
      break;
    case Extreme::intensity:
      for (Light& light : changed.lights) light.gain *= factor;
      break;
    case Extreme::thinness:
      thin_strands(changed, factor);
      break;
  }
  return changed;
}

std::vector<StabilityFigure> study_stability(const Scene& scene, const Tracer& tracer,
                                             const StabilityParams& params, TrialLog& log,
                                             const ProgressCallback& callback) {
  CHECK_MSG(!has_emission(scene), "{} emits light", scene.name);
  std::vector<ExtremeCase> applying;
  std::vector<std::string> keys;
  for (const ExtremeCase& extreme : cases) {
    if (!applies(scene, extreme.extreme)) continue;
    applying.push_back(extreme);
    keys.push_back(fmt::format("{}: {} {}", scene.name, label_of(extreme_labels, extreme.extreme),
                               extreme.value));
  }
  const auto measure = [&](size_t i) {
    return to_values(measure_case(scene, tracer.bounds(), applying[i], params));
  };
  log.complete("stability " + scene.name, keys, measure, callback);
  std::vector<StabilityFigure> figures;
  for (size_t i = 0; i < keys.size(); ++i) {
    figures.push_back(from_values(*log.find(keys[i])));
    figures.back().extreme = applying[i].extreme;
    figures.back().value = applying[i].value;
  }
  return figures;
}

}  // namespace relume

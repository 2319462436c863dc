#include "viewer/commands/study_pictures.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/image/display_transform.h"
#include "core/image/heatmap.h"
#include "core/image/metrics.h"
#include "core/relight/relight.h"
#include "viewer/commands/relight_input.h"

namespace relume {
namespace {

constexpr int quick_shrink = 2;  ///< a quick study's picture is so many times narrower and lower
constexpr float error_range = 0.1f;  ///< errors ten times enlarged, as in the report's figures

/// How the pixels of a picture are made.
struct PictureTrial {
  ReductionMethod method;
  int records;
};

std::vector<PictureTrial> make_trials(const StudyOptions& options) {
  using enum ReductionMethod;
  const bool smooth = options.name == "smooth";
  const int k = options.records.empty() ? (smooth ? 2 : 8) : options.records.front();
  const ReductionMethod ours = options.quick ? light_fit_fast : light_fit;
  std::vector<ReductionMethod> methods = options.methods;
  if (methods.empty()) {
    methods = smooth ? std::vector{pure, light_metric_4, light_metric_1, kmeans, ours}
                     : std::vector{kmeans, pure, strong_kmeans, ours};
  }
  std::vector<PictureTrial> trials;
  for (const ReductionMethod method : methods) trials.push_back({method, k});
  return trials;
}

RelightCache prepare_trial(const RelightInput& input, const StudyOptions& options,
                           const CommonOptions& common, const PictureTrial& trial) {
  PrepareOptions prepare;
  prepare.spp = options.spp;
  prepare.method = trial.method;
  prepare.records = trial.records;
  prepare.training_lights = options.training_lights;
  prepare.train_shadows = options.train_shadows;
  prepare.width = options.width;
  prepare.height = options.height;
  if (options.quick && options.width == 0) prepare.width = input.scene->width / quick_shrink;
  if (options.quick && options.height == 0) prepare.height = input.scene->height / quick_shrink;
  return prepare_in_memory(*input.scene, *input.tracer, make_prepare_params(prepare, common),
                           make_terminal_progress(common.quiet));
}

/// The cache's picture under the scene's own lights.
Image render(const RelightCache& cache, const Tracer& tracer, ShadowMethod shadow) {
  const auto source = shadow == ShadowMethod::none ? nullptr : make_shadow(shadow, tracer, cache);
  RelightState state = make_relight_state(cache);
  relight(state, cache.info().lights, source.get());
  return std::move(state.frame);
}

std::string label_of_trial(const PictureTrial& trial) {
  const auto method = label_of(reduction_method_labels, trial.method);
  return trial.method == ReductionMethod::all ? fmt::format("all {} samples", trial.records)
                                              : fmt::format("{}, k = {}", method, trial.records);
}

std::string name_set(const std::string& scene, ShadowMethod shadow) {
  return shadow == ShadowMethod::none ? scene + ", no shadows" : scene + ", one ray a record";
}

/// One scene's pictures and figures, all samples first.
class ScenePictures {
 public:
  ScenePictures(const RelightInput& input, const std::vector<ShadowMethod>& shadows,
                StudyResult& result)
      : input_(input), shadows_(shadows), result_(result) {}

  void add_reference(const RelightCache& cache, const PictureTrial& trial) {
    coverage_ = cache.coverage();
    for (const ShadowMethod shadow : shadows_) {
      references_.push_back(render(cache, *input_.tracer, shadow));
      add_picture(name_set(name(), shadow), label_of_trial(trial), "", references_.back());
    }
  }

  void add(const RelightCache& cache, const PictureTrial& trial) {
    for (size_t s = 0; s < shadows_.size(); ++s) {
      const Image frame = render(cache, *input_.tracer, shadows_[s]);
      const ImageError error = compare_images(frame, references_[s], coverage_);
      const std::string about =
          fmt::format("error {:.3g} %", 100 * error.error_covered / error.reference_mean);
      add_picture(name_set(name(), shadows_[s]), label_of_trial(trial), about, frame);
      result_.pictures.push_back({name_set(name(), shadows_[s]) + ": error", label_of_trial(trial),
                                  about,
                                  render_heatmap(error_image(frame, references_[s]),
                                                 {.range = error_range, .scale_bar = true})});
      add_row(trial, shadows_[s], cache, error);
    }
  }

 private:
  const std::string& name() const { return input_.scene->name; }

  void add_picture(const std::string& set, const std::string& label, const std::string& about,
                   const Image& frame) {
    result_.pictures.push_back(
        {set, label, about, apply_display(frame, {.exposure = input_.scene->exposure})});
  }

  void add_row(const PictureTrial& trial, ShadowMethod shadow, const RelightCache& cache,
               const ImageError& error) {
    result_.tables.front().rows.push_back(
        {{"scene", name()},
         {"method", std::string(label_of(reduction_method_labels, trial.method))},
         {"records", int64_t{trial.records}},
         {"spp", int64_t{cache.info().spp}},
         {"shadow", std::string(label_of(shadow_method_labels, shadow))},
         {"width", int64_t{cache.info().width}},
         {"height", int64_t{cache.info().height}},
         {"error", error.error_covered},
         {"error_image", error.error_image},
         {"error_max", error.max_error},
         {"error_relative", error.error_covered / error.reference_mean},
         {"reference_mean", error.reference_mean}});
  }

  const RelightInput& input_;
  const std::vector<ShadowMethod>& shadows_;
  StudyResult& result_;
  std::vector<float> coverage_;
  std::vector<Image> references_;  ///< parallel to shadows_
};

}  // namespace

StudyResult run_picture_study(const StudyOptions& options, const CommonOptions& common) {
  StudyResult result{options.name, {{"rows", {}}}, {}, {}};
  const std::vector<ShadowMethod> shadows = options.shadows.empty()
                                                ? std::vector{ShadowMethod::ray, ShadowMethod::none}
                                                : options.shadows;
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_scene(name, common);
    ScenePictures pictures(input, shadows, result);
    const PictureTrial all{ReductionMethod::all, options.spp};
    pictures.add_reference(prepare_trial(input, options, common, all), all);
    for (const PictureTrial& trial : make_trials(options)) {
      pictures.add(prepare_trial(input, options, common, trial), trial);
    }
  }
  std::ranges::stable_sort(result.pictures, {}, &StudyPicture::set);
  if (!common.json) fmt::print("{}", format_table(result.tables.front().rows));
  return result;
}

}  // namespace relume

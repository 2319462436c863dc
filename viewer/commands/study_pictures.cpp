#include "viewer/commands/study_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "core/base/check.h"
#include "core/image/display_transform.h"
#include "core/image/heatmap.h"
#include "core/image/image_io.h"
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

std::vector<ShadowMethod> choose_shadows(const StudyOptions& options) {
  if (!options.shadows.empty()) return options.shadows;
  return {ShadowMethod::ray, ShadowMethod::none};
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

/// What one picture's trial and shadow gave, as the log keeps it.
struct PictureFigure {
  ImageError error;
  int width = 0;  ///< pixels
  int height = 0;
  int map_width = 0;  ///< of the map of the error with its scale; 0 = has none
  int map_height = 0;

  std::vector<double> values() const {
    return {error.error_covered, error.error_image, error.max_error,   error.reference_mean,
            double(width),       double(height),    double(map_width), double(map_height)};
  }
  static PictureFigure from_values(const std::vector<double>& values) {
    CHECK_MSG(values.size() == 8, "{}", values.size());
    PictureFigure figure;
    figure.error.error_covered = values[0];
    figure.error.error_image = values[1];
    figure.error.max_error = values[2];
    figure.error.reference_mean = values[3];
    figure.width = static_cast<int>(values[4]);
    figure.height = static_cast<int>(values[5]);
    figure.map_width = static_cast<int>(values[6]);
    figure.map_height = static_cast<int>(values[7]);
    return figure;
  }
};

/// One scene's pictures and figures. A picture is written before the log says that it was made.
class ScenePictures {
 public:
  ScenePictures(const RelightInput& input, const StudyOptions& options, const CommonOptions& common,
                TrialLog& log, StudyResult& result)
      : input_(input), options_(options), common_(common), log_(log), result_(result) {}

  void add(const PictureTrial& trial, ShadowMethod shadow) {
    const bool is_reference = trial.method == ReductionMethod::all;
    const std::string set = name_set(name(), shadow);
    const std::string file = fmt::format(
        "{}-{}-{}-{}-{}", options_.name, file_part(name()), label_of(shadow_method_labels, shadow),
        label_of(reduction_method_labels, trial.method), trial.records);
    const std::vector<double>* known = log_.find(file);
    if (known == nullptr) known = &log_.add(file, draw(trial, shadow, file).values());
    const PictureFigure figure = PictureFigure::from_values(*known);
    const ImageError& error = figure.error;
    const std::string about =
        is_reference
            ? ""
            : fmt::format("error {:.3g} %", 100 * error.error_covered / error.reference_mean);
    result_.pictures.push_back(
        {set, label_of_trial(trial), about, file + ".png", figure.width, figure.height});
    if (is_reference) return;
    result_.pictures.push_back({set + ": error", label_of_trial(trial), about, file + "-error.png",
                                figure.map_width, figure.map_height});
    add_row(trial, shadow, figure);
  }

 private:
  const std::string& name() const { return input_.scene->name; }

  /// The records of the last trial asked for.
  const RelightCache& records(const PictureTrial& trial) {
    if (!cache_ || cached_ != label_of_trial(trial)) {
      cache_.reset();
      cache_ = prepare_trial(input_, options_, common_, trial);
      cached_ = label_of_trial(trial);
    }
    return *cache_;
  }

  /// All samples, the picture that others are held against.
  const Image& reference(ShadowMethod shadow) {
    if (references_.empty()) {
      const RelightCache all =
          prepare_trial(input_, options_, common_, {ReductionMethod::all, options_.spp});
      coverage_ = all.coverage();
      for (const ShadowMethod each : choose_shadows(options_)) {
        references_.emplace(each, render(all, *input_.tracer, each));
      }
    }
    return references_.at(shadow);
  }

  PictureFigure draw(const PictureTrial& trial, ShadowMethod shadow, const std::string& file) {
    const Image& expected = reference(shadow);
    const bool is_reference = trial.method == ReductionMethod::all;
    const Image frame = is_reference ? expected : render(records(trial), *input_.tracer, shadow);
    PictureFigure figure{compare_images(frame, expected, coverage_), frame.width, frame.height, 0,
                         0};
    write(file, apply_display(frame, {.exposure = input_.scene->exposure}));
    if (is_reference) return figure;
    const DisplayImage map =
        render_heatmap(error_image(frame, expected), {.range = error_range, .scale_bar = true});
    figure.map_width = map.width;
    figure.map_height = map.height;
    write(file + "-error", map);
    return figure;
  }

  void write(const std::string& file, const DisplayImage& image) const {
    if (options_.output) write_png(*options_.output / (file + ".png"), image);
  }

  void add_row(const PictureTrial& trial, ShadowMethod shadow, const PictureFigure& figure) {
    const ImageError& error = figure.error;
    result_.tables.front().rows.push_back(
        {{"scene", name()},
         {"method", std::string(label_of(reduction_method_labels, trial.method))},
         {"records", int64_t{trial.records}},
         {"spp", int64_t{trial.method == ReductionMethod::pure ? trial.records : options_.spp}},
         {"shadow", std::string(label_of(shadow_method_labels, shadow))},
         {"width", int64_t{figure.width}},
         {"height", int64_t{figure.height}},
         {"error", error.error_covered},
         {"error_image", error.error_image},
         {"error_max", error.max_error},
         {"error_relative", error.error_covered / error.reference_mean},
         {"reference_mean", error.reference_mean}});
  }

  const RelightInput& input_;
  const StudyOptions& options_;
  const CommonOptions& common_;
  TrialLog& log_;
  StudyResult& result_;
  std::vector<float> coverage_;
  std::map<ShadowMethod, Image> references_;
  std::optional<RelightCache> cache_;
  std::string cached_;
};

}  // namespace

StudyResult run_picture_study(const StudyOptions& options, const CommonOptions& common,
                              TrialLog& log) {
  StudyResult result{options.name, {{"rows", {}}}, {}, {}};
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_study_scene(name, common);
    ScenePictures pictures(input, options, common, log, result);
    std::vector<PictureTrial> trials = make_trials(options);
    trials.insert(trials.begin(), {ReductionMethod::all, options.spp});
    for (const PictureTrial& trial : trials) {
      for (const ShadowMethod shadow : choose_shadows(options)) pictures.add(trial, shadow);
    }
  }
  std::ranges::stable_sort(result.pictures, {}, &StudyPicture::set);
  if (!common.json) fmt::print("{}", format_table(result.tables.front().rows));
  return result;
}

}  // namespace relume

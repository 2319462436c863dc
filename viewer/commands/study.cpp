#include <fmt/format.h>

#include <map>

#include "core/base/file.h"
#include "core/base/timer.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/commands/study_shadows.h"
#include "viewer/study/method_study.h"

namespace relume {
namespace {

constexpr int full_lights = 50;
constexpr int quick_lights = 16;
constexpr int quick_tiles = 24;
constexpr int budget_limit = 16;  ///< most records of a pixel under a budget
constexpr int report_spp = 25;    ///< TR2007-600 sec. 4.1

std::vector<MethodTrial> make_trials(const StudyOptions& options) {
  std::vector<ReductionMethod> methods = options.methods;
  if (methods.empty()) {
    for (const auto& [method, label] : reduction_method_labels) {
      if (method != ReductionMethod::all) methods.push_back(method);
    }
  }
  std::vector<MethodTrial> trials;
  if (options.truth_spp > 0) {
    // What the report starts from, with and without its reduction, is as far from the truth as it
    // is.
    trials.push_back({ReductionMethod::all, report_spp, report_spp, {}});
    trials.push_back({ReductionMethod::kmeans, report_spp, 8, {}});
    if (options.spp != report_spp) {
      trials.push_back({ReductionMethod::all, options.spp, options.spp, {}});
    }
  }
  for (const ReductionMethod method : methods) {
    for (const int k : options.records) trials.push_back({method, options.spp, k, {}});
    if (method != ReductionMethod::light_fit) continue;
    for (const double average : options.average_records) {
      if (!(average > 0)) continue;
      trials.push_back(
          {method, options.spp, budget_limit, {.average_records = static_cast<float>(average)}});
    }
  }
  return trials;
}

MethodStudyParams make_study_params(const StudyOptions& options, const Scene& scene,
                                    const CommonOptions& common) {
  MethodStudyParams params;
  params.trials = make_trials(options);
  params.lights = options.lights > 0 ? options.lights : options.quick ? quick_lights : full_lights;
  params.width = options.width;
  params.height = options.height;
  params.tile_stride = options.tile_stride;
  if (params.tile_stride == 0) {
    const int width = options.width > 0 ? options.width : scene.width;
    const int height = options.height > 0 ? options.height : scene.height;
    const int tiles = width * height / (tile_size * tile_size);
    params.tile_stride = options.quick ? std::max(1, tiles / quick_tiles) : 1;
  }
  params.is_independent = options.truth_spp > 0;
  params.reference_spp = params.is_independent ? options.truth_spp : options.spp;
  params.training = {
      .lights = options.training_lights, .shadows = options.train_shadows, .seed = common.seed};
  params.seed = common.seed;
  return params;
}

std::string label_of_trial(const MethodTrial& trial) {
  const auto method = label_of(reduction_method_labels, trial.method);
  if (trial.method == ReductionMethod::all) return fmt::format("all {} samples", trial.spp);
  const std::string from =
      trial.spp == report_spp ? "" : fmt::format(" from {} samples", trial.spp);
  return trial.budget.is_set()
             ? fmt::format("{}, average {:g}{}", method, trial.budget.average_records, from)
             : fmt::format("{}, k = {}{}", method, trial.records, from);
}

/// The report's K-means at the same k, or nothing.
const MethodFigure* kmeans_figure(const std::vector<MethodFigure>& figures, int k) {
  for (const MethodFigure& figure : figures) {
    if (figure.trial.method == ReductionMethod::kmeans && figure.trial.records == k) return &figure;
  }
  return nullptr;
}

/// What a figure is held against: K-means at the same k; a budget's at k = 8.
const MethodFigure* base_of(const std::vector<MethodFigure>& figures, const MethodFigure& figure) {
  return kmeans_figure(figures, figure.trial.budget.is_set() ? 8 : figure.trial.records);
}

FigureRow to_row(const std::string& scene, const MethodFigure& figure,
                 const std::vector<MethodFigure>& figures, const MethodStudyParams& params) {
  const MethodTrial& trial = figure.trial;
  FigureRow row{{"scene", scene},
                {"method", std::string(label_of(reduction_method_labels, trial.method))},
                {"records", int64_t{trial.records}},
                {"budget", double{trial.budget.average_records}},
                {"average_records", figure.average_records},
                {"spp", int64_t{trial.spp}},
                {"reference_spp", int64_t{params.reference_spp}},
                {"shadow", std::string("none")},
                {"lights", static_cast<int64_t>(figure.errors.size())},
                {"error", figure.error},
                {"error_stddev", figure.error_stddev},
                {"error_image", figure.error_image},
                {"error_relative", figure.error / figure.reference_mean},
                {"predicted_error", figure.predicted_error},
                {"reference_mean", figure.reference_mean},
                {"covered_pixels", figure.covered_pixels},
                {"thread_ms_reduce", figure.thread_ms_reduce}};
  if (const MethodFigure* base = base_of(figures, figure)) {
    row.push_back({"ratio_to_kmeans", figure.error / base->error});
  }
  return row;
}

void print_table(const std::string& scene, const std::vector<MethodFigure>& figures,
                 const MethodStudyParams& params) {
  fmt::print(
      "\n{}: eq. 7, percent of the reference's mean, {} lights, {} covered pixels, against "
      "{} {} samples a pixel\n\n",
      scene, params.lights, figures.front().covered_pixels,
      params.is_independent ? "an independent" : "all", params.reference_spp);
  fmt::print(
      "| method | error, % | of K-means | records a pixel | predicted, % | reduce, us a pixel |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- |\n");
  for (const MethodFigure& figure : figures) {
    const MethodFigure* base = base_of(figures, figure);
    const double percent = 100 / figure.reference_mean;
    fmt::print(
        "| {} | {:.4f} +- {:.4f} | {} | {:.2f} | {} | {:.1f} |\n", label_of_trial(figure.trial),
        percent * figure.error,
        percent * figure.error_stddev / std::sqrt(static_cast<double>(figure.errors.size())),
        base == nullptr ? "" : fmt::format("{:.3f}", figure.error / base->error),
        figure.average_records,
        figure.predicted_error > 0 ? fmt::format("{:.4f}", percent * figure.predicted_error) : "",
        1e3 * figure.thread_ms_reduce / static_cast<double>(figure.covered_pixels));
  }
}

}  // namespace

int run_study(const StudyOptions& options, const CommonOptions& common) {
  if (options.name == "shadows") return run_shadow_study(options, common);
  std::vector<FigureRow> rows;
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_scene(name, common);
    const MethodStudyParams params = make_study_params(options, *input.scene, common);
    const std::vector<MethodFigure> figures =
        study_methods(*input.scene, *input.tracer, params, make_terminal_progress(common.quiet));
    if (!common.json) print_table(input.scene->name, figures, params);
    for (const MethodFigure& figure : figures) {
      rows.push_back(to_row(input.scene->name, figure, figures, params));
    }
  }
  const std::string json = format_figures("relume-study-methods-1", common, rows);
  if (common.json) fmt::print("{}", json);
  if (options.output) {
    make_folder(*options.output);
    write_file_atomic(*options.output / "methods.json", json);
    write_file_atomic(*options.output / "methods.csv", format_csv(rows));
  }
  return 0;
}

}  // namespace relume

#include "viewer/commands/study_methods.h"

#include <fmt/format.h>

#include <cmath>

#include "viewer/commands/relight_input.h"
#include "viewer/study/method_study.h"
#include "viewer/study/significance.h"

namespace relume {
namespace {

constexpr int full_lights = 50;
constexpr int quick_lights = 16;
constexpr int quick_tiles = 24;
constexpr int budget_limit = 16;  ///< most records of a pixel under a budget
constexpr int report_spp = 25;    ///< TR2007-600 sec. 4.1

/// The numbers of training lights of TR2007-600 sec. 4.4.
constexpr std::array report_training_lights = {12, 25, 50, 100, 200, 400, 800};

std::vector<ReductionMethod> choose_methods(const StudyOptions& options) {
  if (!options.methods.empty()) return options.methods;
  using enum ReductionMethod;
  if (options.name == "rates") {
    return {pure, kmeans, strong_kmeans, light_metric_1, light_metric_4, light_fit};
  }
  if (options.name == "lights") return {light_metric_1, light_metric_4};
  std::vector<ReductionMethod> methods;
  for (const auto& [method, label] : reduction_method_labels) {
    if (method != all) methods.push_back(method);
  }
  return methods;
}

std::vector<int> choose_records(const StudyOptions& options) {
  if (!options.records.empty()) return options.records;
  return options.name == "rates" ? std::vector{8, 4, 2} : std::vector{8};
}

std::vector<double> choose_budgets(const StudyOptions& options) {
  if (!options.average_records.empty()) return options.average_records;
  return options.name == "rates" ? std::vector<double>{4, 3, 2} : std::vector<double>{3};
}

/// Experiment 3: K-means, which is trained on nothing, and the light metrics by number of lights.
std::vector<MethodTrial> make_light_trials(const StudyOptions& options) {
  std::vector<MethodTrial> trials;
  for (const int k : choose_records(options)) {
    trials.push_back({ReductionMethod::kmeans, options.spp, k, {}});
    for (const ReductionMethod method : choose_methods(options)) {
      for (const bool shadows : {false, true}) {
        for (const int lights : report_training_lights) {
          if (shadows && options.quick && lights > 200) continue;
          trials.push_back({method, options.spp, k, {}, lights, shadows});
        }
      }
    }
  }
  return trials;
}

/// Light metrics are trained without shadows and, as the report's were, with them; where methods
/// are chosen by hand, as the option says.
std::vector<bool> choose_training_shadows(const StudyOptions& options, ReductionMethod method) {
  const bool is_metric = needs_training(method) && !is_light_fit(method);
  if (is_metric && options.methods.empty() && !options.train_shadows) return {false, true};
  return {false};
}

std::vector<MethodTrial> make_trials(const StudyOptions& options) {
  if (options.name == "lights") return make_light_trials(options);
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
  for (const ReductionMethod method : choose_methods(options)) {
    for (const bool shadows : choose_training_shadows(options, method)) {
      for (const int k : choose_records(options)) {
        trials.push_back({method, options.spp, k, {}, 0, shadows});
      }
    }
    if (method != ReductionMethod::light_fit) continue;
    for (const double average : choose_budgets(options)) {
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
  params.shadows = options.shadows.empty() ? std::vector{ShadowMethod::none, ShadowMethod::ray}
                                           : options.shadows;
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
  std::string trained;
  if (trial.training_lights > 0) trained = fmt::format(", {} lights", trial.training_lights);
  if (trial.train_shadows) trained += " with shadows";
  return trial.budget.is_set()
             ? fmt::format("{}, average {:g}{}", method, trial.budget.average_records, from)
             : fmt::format("{}, k = {}{}{}", method, trial.records, from, trained);
}

using Figures = std::vector<MethodFigure>;

/// The report's K-means at the same k and shadow, a budget against k = 8; nothing where there is
/// none or it has no error.
const MethodFigure* base_of(const Figures& figures, const MethodFigure& figure) {
  const int k = figure.trial.budget.is_set() ? 8 : figure.trial.records;
  for (const MethodFigure& base : figures) {
    if (base.trial.method == ReductionMethod::kmeans && base.trial.records == k &&
        base.shadow == figure.shadow) {
      return base.error > 0 ? &base : nullptr;
    }
  }
  return nullptr;
}

std::string shadow_label(const MethodFigure& figure) {
  return std::string(label_of(shadow_method_labels, figure.shadow));
}

FigureRow to_row(const std::string& scene, const MethodFigure& figure, const Figures& figures,
                 const MethodStudyParams& params, bool timed) {
  const MethodTrial& trial = figure.trial;
  const int training = trial.training_lights > 0 ? trial.training_lights : params.training.lights;
  const bool is_trained = needs_training(trial.method) && !is_light_fit(trial.method);
  FigureRow row{{"scene", scene},
                {"method", std::string(label_of(reduction_method_labels, trial.method))},
                {"records", int64_t{trial.records}},
                {"budget", double{trial.budget.average_records}},
                {"average_records", figure.average_records},
                {"spp", int64_t{trial.spp}},
                {"reference_spp", int64_t{params.reference_spp}},
                {"shadow", shadow_label(figure)},
                {"training_lights", int64_t{is_trained ? training : 0}},
                {"train_shadows", is_trained && (params.training.shadows || trial.train_shadows)},
                {"lights", static_cast<int64_t>(figure.errors.size())},
                {"error", figure.error},
                {"error_stddev", figure.error_stddev},
                {"error_half_95", figure.error_half_95},
                {"error_image", figure.error_image},
                {"error_relative", figure.error / figure.reference_mean},
                {"predicted_error", figure.predicted_error},
                {"reference_mean", figure.reference_mean},
                {"covered_pixels", figure.covered_pixels}};
  if (timed) row.push_back({"thread_ms_reduce", figure.thread_ms_reduce});
  if (const MethodFigure* base = base_of(figures, figure)) {
    row.push_back({"ratio_to_kmeans", figure.error / base->error});
  }
  return row;
}

/// Two figures under the same lights, shadow and number of records.
FigureRow to_pair(const std::string& scene, const MethodFigure& a, const MethodFigure& b) {
  std::vector<double> differences;
  int64_t wins = 0;
  for (size_t i = 0; i < a.errors.size(); ++i) {
    differences.push_back(a.errors[i] - b.errors[i]);
    if (a.errors[i] < b.errors[i]) ++wins;
  }
  const MeanInterval interval = mean_interval(differences);
  return {{"scene", scene},
          {"shadow", shadow_label(a)},
          {"records", int64_t{a.trial.records}},
          {"a", label_of_trial(a.trial)},
          {"b", label_of_trial(b.trial)},
          {"lights", static_cast<int64_t>(differences.size())},
          {"ratio", a.error / b.error},
          {"difference", interval.mean},
          {"difference_half_95", interval.half_95},
          {"a_is_better", wins},
          {"p", signed_rank_p(differences)}};
}

bool are_comparable(const MethodFigure& a, const MethodFigure& b) {
  const auto k = [](const MethodFigure& figure) {
    return figure.trial.budget.is_set() ? 8 : figure.trial.records;
  };
  return a.shadow == b.shadow && k(a) == k(b);
}

void add_pairs(const std::string& scene, const Figures& figures, FigureTable& table) {
  const size_t first = table.rows.size();
  std::vector<double> p_values;
  for (size_t i = 0; i < figures.size(); ++i) {
    for (size_t j = i + 1; j < figures.size(); ++j) {
      if (!are_comparable(figures[i], figures[j])) continue;
      table.rows.push_back(to_pair(scene, figures[i], figures[j]));
      p_values.push_back(std::get<double>(table.rows.back().back().second));
    }
  }
  const std::vector<double> adjusted = holm_adjust(p_values);
  for (size_t i = 0; i < adjusted.size(); ++i) {
    table.rows[first + i].push_back({"p_holm", adjusted[i]});
  }
}

void add_trials(const std::string& scene, const MethodFigure& figure, FigureTable& table) {
  for (size_t i = 0; i < figure.errors.size(); ++i) {
    table.rows.push_back({{"scene", scene},
                          {"method", label_of_trial(figure.trial)},
                          {"shadow", shadow_label(figure)},
                          {"light", static_cast<int64_t>(i)},
                          {"error", figure.errors[i]}});
  }
}

void print_table(const std::string& scene, const Figures& figures,
                 const MethodStudyParams& params) {
  fmt::print(
      "\n{}: eq. 7, percent of the reference's mean, {} lights, {} covered pixels, against "
      "{} {} samples a pixel\n\n",
      scene, params.lights, figures.front().covered_pixels,
      params.is_independent ? "an independent" : "all", params.reference_spp);
  fmt::print(
      "| method | shadow | error, % | of K-means | records a pixel | predicted, % | reduce, us a "
      "pixel |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (const MethodFigure& figure : figures) {
    const MethodFigure* base = base_of(figures, figure);
    const double percent = 100 / figure.reference_mean;
    fmt::print(
        "| {} | {} | {:.4f} +- {:.4f} | {} | {:.2f} | {} | {:.1f} |\n",
        label_of_trial(figure.trial), shadow_label(figure), percent * figure.error,
        percent * figure.error_half_95,
        base == nullptr ? "" : fmt::format("{:.3f}", figure.error / base->error),
        figure.average_records,
        figure.predicted_error > 0 ? fmt::format("{:.4f}", percent * figure.predicted_error) : "",
        1e3 * figure.thread_ms_reduce / static_cast<double>(figure.covered_pixels));
  }
}

}  // namespace

StudyResult run_method_study(const StudyOptions& options, const CommonOptions& common,
                             TrialLog& log) {
  FigureTable rows{"rows", {}};
  FigureTable pairs{"pairs", {}};
  FigureTable trials{"trials", {}};
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_study_scene(name, common);
    const std::string& scene = input.scene->name;
    const MethodStudyParams params = make_study_params(options, *input.scene, common);
    const Figures figures = study_methods(*input.scene, *input.tracer, params, log,
                                          make_terminal_progress(common.quiet));
    if (!common.json) print_table(scene, figures, params);
    for (const MethodFigure& figure : figures) {
      rows.rows.push_back(to_row(scene, figure, figures, params, options.timed));
      add_trials(scene, figure, trials);
    }
    if (options.name != "lights") add_pairs(scene, figures, pairs);
  }
  StudyResult result{options.name, {std::move(rows)}, {}, {std::move(trials)}};
  if (!pairs.rows.empty()) result.tables.push_back(std::move(pairs));
  return result;
}

}  // namespace relume

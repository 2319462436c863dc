#include "viewer/commands/study_tradeoff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "viewer/commands/relight_input.h"
#include "viewer/study/tradeoff_study.h"

namespace relume {
namespace {

constexpr int full_lights = 8;
constexpr int quick_lights = 3;
constexpr int full_truth_spp = 256;
constexpr int quick_truth_spp = 128;
constexpr int quick_shrink = 2;   ///< a quick study's picture is so many times narrower and lower
constexpr int budget_limit = 16;  ///< most records of a pixel under a budget
constexpr int report_spp = 25;
constexpr std::array traced_spp = {1, 2, 4, 8, 16, 32, 64};

/// What a move may take, in milliseconds.
struct TimeLimit {
  const char* name;
  double ms;
};
constexpr std::array time_limits = {
    TimeLimit{"30 ms", 30},
    TimeLimit{"100 ms", 100},
    TimeLimit{"best", std::numeric_limits<double>::infinity()},
};

/// Records to be made, in one format each.
struct RecordChoice {
  ReductionMethod method;
  int records;
  RecordBudget budget;
};

std::vector<RecordChoice> choose_records(const StudyOptions& options) {
  using enum ReductionMethod;
  std::vector<ReductionMethod> methods = options.methods;
  if (methods.empty()) {
    methods = options.quick ? std::vector{pure, strong_kmeans, light_fit_fast}
                            : std::vector{pure, kmeans, strong_kmeans, light_fit_fast, light_fit};
  }
  std::vector<int> counts = options.records;
  if (counts.empty()) counts = {8, 4, 2};
  std::vector<RecordChoice> choices{{all, report_spp, {}}};
  for (const ReductionMethod method : methods) {
    for (const int k : counts) choices.push_back({method, k, {}});
  }
  std::vector<double> budgets = options.average_records;
  if (budgets.empty()) budgets = options.quick ? std::vector{3.0} : std::vector{4.0, 3.0, 2.0};
  const ReductionMethod fitted = options.quick ? light_fit_fast : light_fit;
  for (const double average : budgets) {
    if (!(average > 0)) continue;
    choices.push_back({fitted, budget_limit, {.average_records = static_cast<float>(average)}});
  }
  return choices;
}

/// Packed formats are measured where records are fewest: on fitted ones and under budgets.
std::vector<CacheFormat> choose_formats(const StudyOptions& options, const RecordChoice& choice) {
  if (!is_light_fit(choice.method)) return {CacheFormat::exact};
  if (options.quick && !choice.budget.is_set()) return {CacheFormat::exact};
  if (options.quick) return {CacheFormat::exact, CacheFormat::compact};
  return {CacheFormat::exact, CacheFormat::standard, CacheFormat::compact};
}

std::vector<ShadowMethod> choose_shadows(const StudyOptions& options) {
  if (!options.shadows.empty()) return options.shadows;
  using enum ShadowMethod;
  if (options.quick) return {none, ray, coverage, volume};
  std::vector<ShadowMethod> shadows;
  for (const auto& [shadow, label] : shadow_method_labels) shadows.push_back(shadow);
  return shadows;
}

std::vector<TradeoffTrial> make_trials(const StudyOptions& options) {
  std::vector<TradeoffTrial> trials;
  for (const RecordChoice& choice : choose_records(options)) {
    for (const CacheFormat format : choose_formats(options, choice)) {
      for (const ShadowMethod shadow : choose_shadows(options)) {
        for (const PixelShare pixels : {PixelShare::all, PixelShare::quarter}) {
          trials.push_back({choice.method, choice.records, choice.budget, format, shadow, pixels});
        }
      }
    }
  }
  return trials;
}

TradeoffParams make_study_params(const StudyOptions& options, const Scene& scene,
                                 const CommonOptions& common) {
  TradeoffParams params;
  params.trials = make_trials(options);
  params.traced_spp.assign(traced_spp.begin(), traced_spp.end());
  params.spp = options.spp;
  params.truth_spp = options.truth_spp > 0 ? options.truth_spp
                     : options.quick       ? quick_truth_spp
                                           : full_truth_spp;
  params.lights = options.lights > 0 ? options.lights : options.quick ? quick_lights : full_lights;
  params.lights = std::max(2, params.lights);  // with one there is nothing to move to
  params.width = options.width;
  params.height = options.height;
  if (options.quick && options.width == 0) params.width = scene.width / quick_shrink;
  if (options.quick && options.height == 0) params.height = scene.height / quick_shrink;
  params.training = {
      .lights = options.training_lights, .shadows = options.train_shadows, .seed = common.seed};
  params.seed = common.seed;
  return params;
}

std::string label_of_figure(const TradeoffFigure& figure) {
  if (figure.traced_spp > 0) return fmt::format("traced anew, {} samples", figure.traced_spp);
  const TradeoffTrial& trial = figure.trial;
  const auto method = label_of(reduction_method_labels, trial.method);
  std::string text = trial.budget.is_set()
                         ? fmt::format("{}, average {:g}", method, trial.budget.average_records)
                         : fmt::format("{}, k = {}", method, trial.records);
  if (trial.method == ReductionMethod::all) text = fmt::format("all {} samples", trial.records);
  text += fmt::format(", {}, shadows {}", label_of(cache_format_labels, trial.format),
                      label_of(shadow_method_labels, trial.shadow));
  return trial.pixels == PixelShare::all ? text : text + ", a quarter of the pixels";
}

FigureRow to_row(const std::string& scene, const TradeoffStudy& study, const TradeoffFigure& figure,
                 const TradeoffParams& params) {
  const TradeoffTrial& trial = figure.trial;
  const bool traced = figure.traced_spp > 0;
  const auto text = [traced](std::string_view label) {
    return traced ? std::string("traced") : std::string(label);
  };
  return {{"scene", scene},
          {"setting", label_of_figure(figure)},
          {"method", text(label_of(reduction_method_labels, trial.method))},
          {"records", int64_t{traced ? figure.traced_spp : trial.records}},
          {"budget", double{trial.budget.average_records}},
          {"format", text(label_of(cache_format_labels, trial.format))},
          {"shadow", traced ? "ray" : std::string(label_of(shadow_method_labels, trial.shadow))},
          {"pixels", std::string(trial.pixels == PixelShare::all ? "all" : "quarter")},
          {"width", int64_t{study.width}},
          {"height", int64_t{study.height}},
          {"spp", int64_t{traced ? figure.traced_spp : params.spp}},
          {"truth_spp", int64_t{params.truth_spp}},
          {"lights", int64_t{params.lights}},
          {"average_records", figure.average_records},
          {"error", figure.error},
          {"error_stddev", figure.error_stddev},
          {"error_half_95", figure.error_half_95},
          {"error_relative", figure.error / figure.reference_mean},
          {"reference_mean", figure.reference_mean},
          {"ms_light", figure.ms_light},
          {"ms_prepare", figure.ms_prepare},
          {"cache_bytes", figure.cache_bytes},
          {"pareto", figure.is_pareto}};
}

void recommend_all(const std::string& scene, const TradeoffStudy& study, bool quiet,
                   FigureTable& table) {
  if (!quiet) fmt::print("\n{}, {} x {}:\n", scene, study.width, study.height);
  for (const TimeLimit& limit : time_limits) {
    const TradeoffFigure* figure = recommend(study.figures, limit.ms);
    if (figure == nullptr) continue;
    const double error = figure->error / figure->reference_mean;
    table.rows.push_back({{"scene", scene},
                          {"limit", std::string(limit.name)},
                          {"setting", label_of_figure(*figure)},
                          {"error_relative", error},
                          {"ms_light", figure->ms_light},
                          {"within", figure->ms_light <= limit.ms}});
    if (quiet) continue;
    fmt::print("  {}: {}: {:.2f} %, {:.1f} ms\n", limit.name, label_of_figure(*figure), 100 * error,
               figure->ms_light);
  }
}

}  // namespace

StudyResult run_tradeoff_study(const StudyOptions& options, const CommonOptions& common,
                               TrialLog& log) {
  StudyResult result{options.name, {{"rows", {}}, {"recommended", {}}}, {}, {}};
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_study_scene(name, common);
    const std::string& scene = input.scene->name;
    const TradeoffParams params = make_study_params(options, *input.scene, common);
    const TradeoffStudy study = study_tradeoff(*input.scene, *input.tracer, params, log,
                                               make_terminal_progress(common.quiet));
    for (const TradeoffFigure& figure : study.figures) {
      result.tables[0].rows.push_back(to_row(scene, study, figure, params));
    }
    recommend_all(scene, study, common.json, result.tables[1]);
  }
  return result;
}

}  // namespace relume

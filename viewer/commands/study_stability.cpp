#include "viewer/commands/study_stability.h"

#include <fmt/format.h>

#include "viewer/commands/relight_input.h"
#include "viewer/study/stability_study.h"

namespace relume {
namespace {

constexpr int quick_size = 64;  ///< pixels

StabilityParams make_study_params(const StudyOptions& options, const CommonOptions& common) {
  StabilityParams params;
  params.spp = options.spp;
  params.seed = common.seed;
  if (!options.records.empty()) params.records = options.records.front();
  if (options.quick) params.width = params.height = quick_size;
  if (options.width > 0) params.width = options.width;
  if (options.height > 0) params.height = options.height;
  return params;
}

FigureRow to_row(const std::string& scene, const StabilityFigure& figure) {
  return {{"scene", scene},
          {"extreme", std::string(label_of(extreme_labels, figure.extreme))},
          {"value", figure.value},
          {"covered_pixels", figure.covered_pixels},
          {"error_relative", figure.error_relative},
          {"error_max", figure.error_max},
          {"error_reduced", figure.error_reduced},
          {"visibility", figure.visibility},
          {"replaced_values", figure.replaced_values},
          {"non_finite_values", figure.non_finite_values}};
}

}  // namespace

StudyResult run_stability_study(const StudyOptions& options, const CommonOptions& common,
                                TrialLog& log) {
  StudyResult result{options.name, {{"rows", {}}}, {}, {}};
  const StabilityParams params = make_study_params(options, common);
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_study_scene(name, common);
    for (const StabilityFigure& figure : study_stability(*input.scene, *input.tracer, params, log,
                                                         make_terminal_progress(common.quiet))) {
      result.tables.front().rows.push_back(to_row(input.scene->name, figure));
    }
  }
  if (!common.json) fmt::print("{}", format_table(result.tables.front().rows));
  return result;
}

}  // namespace relume

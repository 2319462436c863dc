#include "viewer/commands/study_shadows.h"

#include <fmt/format.h>

#include "core/image/image_io.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/study/shadow_study.h"

namespace relume {
namespace {

constexpr int default_truth_spp = 256;
constexpr int quick_window = 96;  ///< pixels

std::vector<ShadowTrial> make_trials(const StudyOptions& options) {
  std::vector<ReductionMethod> methods = options.methods;
  if (methods.empty() && options.quick) {
    methods = {ReductionMethod::strong_kmeans, ReductionMethod::light_fit};
  } else if (methods.empty()) {
    methods = {ReductionMethod::strong_kmeans, ReductionMethod::kmeans, ReductionMethod::light_fit};
  }
  std::vector<ShadowMethod> shadows = options.shadows;
  if (shadows.empty()) {
    for (const auto& [shadow, label] : shadow_method_labels) {
      // What auto picks has a row of its own.
      if (shadow != ShadowMethod::automatic) shadows.push_back(shadow);
    }
  }
  std::vector<int> records = options.records;
  if (records.empty()) records = options.quick ? std::vector{8} : std::vector{8, 4, 2};
  std::vector<ShadowTrial> trials;
  for (const ReductionMethod method : methods) {
    for (const int k : records) {
      for (const ShadowMethod shadow : shadows) trials.push_back({shadow, method, k});
    }
  }
  return trials;
}

ShadowStudyParams make_study_params(const StudyOptions& options, const CommonOptions& common) {
  ShadowStudyParams params;
  params.trials = make_trials(options);
  params.spp = options.spp;
  params.truth_spp = options.truth_spp > 0 ? options.truth_spp : default_truth_spp;
  params.width = options.width;
  params.height = options.height;
  params.window = options.window > 0 ? options.window : options.quick ? quick_window : 0;
  params.timed = options.timed;
  params.keep_maps = options.pictures;
  params.training = {
      .lights = options.training_lights, .shadows = options.train_shadows, .seed = common.seed};
  params.seed = common.seed;
  return params;
}

std::string label_of_trial(const ShadowTrial& trial) {
  const auto shadow = label_of(shadow_method_labels, trial.shadow);
  if (trial.method == ReductionMethod::all) {
    return fmt::format("all {} samples, {}", trial.records, shadow);
  }
  return fmt::format("{}, k = {}, {}", label_of(reduction_method_labels, trial.method),
                     trial.records, shadow);
}

FigureRow to_row(const std::string& scene, const ShadowFigure& figure,
                 const ShadowLightFigure& light, const ShadowStudyParams& params,
                 uint64_t primitives) {
  const ShadowTimes& times = figure.times;
  const ShadowMethod shadow = figure.trial.shadow;
  const bool is_ray = shadow == ShadowMethod::ray;
  const bool draws = shadow == ShadowMethod::coverage || shadow == ShadowMethod::opacity;
  const double move_s = times.ms_move * 1e-3;
  const double percent = light.reference_mean > 0 ? 1 / light.reference_mean : 0;
  return {
      {"scene", scene},
      {"method", std::string(label_of(reduction_method_labels, figure.trial.method))},
      {"records", int64_t{figure.trial.records}},
      {"average_records", figure.average_records},
      {"spp", int64_t{params.spp}},
      {"truth_spp", int64_t{params.truth_spp}},
      {"shadow", std::string(label_of(shadow_method_labels, figure.trial.shadow))},
      {"light", light.light},
      {"truth_visibility", light.truth_visibility},
      {"mae", light.visibility.mae},
      {"bias", light.visibility.bias},
      {"noise", light.visibility.noise},
      {"flicker", light.flicker},
      {"truth_change", light.truth_change},
      {"error", light.error},
      {"error_relative", light.error * percent},
      {"error_of_all", light.error_of_all},
      {"error_of_all_relative", light.error_of_all * percent},
      {"reference_mean", light.reference_mean},
      {"ms_prepare", times.ms_prepare},
      {"ms_move", times.ms_move},
      {"ms_coarse", times.ms_coarse},
      {"coarse_ratio_to_ray", times.coarse_ratio_to_ray},
      {"ratio_to_ray", times.ratio_to_ray},
      {"ratio_to_all", times.ratio_to_all},
      {"records_per_s", times.records_per_s},
      {"rays_per_s", is_ray ? times.records_per_s : 0.0},
      {"primitives", static_cast<int64_t>(primitives)},
      {"primitives_per_s", draws && move_s > 0 ? static_cast<double>(primitives) / move_s : 0.0},
      {"structure_bytes", static_cast<int64_t>(figure.structure_bytes)}};
}

void print_table(const std::string& scene, const ShadowStudy& study,
                 const ShadowStudyParams& params) {
  fmt::print(
      "\n{}: visibility of {} x {} pixels at {} {} against {} traced samples a pixel, mean over {} "
      "lights; errors of the shadowed picture (eq. 7) in percent of the truth's mean\n\n",
      scene, study.window.width, study.window.height, study.window.x0, study.window.y0,
      params.truth_spp, study.lights.size());
  fmt::print("| records, shadow | mean error |");
  for (const StudyLight& light : study.lights) fmt::print(" {} |", light.name);
  fmt::print(
      " bias | noise | flicker | eq. 7, % | of all samples, % | ms a move | of one ray a record | "
      "of all rays | coarse, of one ray a record | MiB |\n|");
  for (size_t i = 0; i < 12 + study.lights.size(); ++i) fmt::print(" --- |");
  fmt::print("\n");
  for (const ShadowFigure& figure : study.figures) {
    const ShadowLightFigure mean = mean_figure(figure);
    fmt::print("| {} | {:.4f} |", label_of_trial(figure.trial), mean.visibility.mae);
    for (const ShadowLightFigure& light : figure.lights) {
      fmt::print(" {:.4f} |", light.visibility.mae);
    }
    const double percent = mean.reference_mean > 0 ? 100 / mean.reference_mean : 0;
    fmt::print(" {:.4f} | {:.4f} | {:.4f} | {:.2f} | {:.2f} |", mean.visibility.bias,
               mean.visibility.noise, mean.flicker, percent * mean.error,
               percent * mean.error_of_all);
    const ShadowTimes& times = figure.times;
    if (times.ms_move > 0) {
      fmt::print(" {:.1f} | {:.4f} | {:.4f} | {:.4f} |", times.ms_move, times.ratio_to_ray,
                 times.ratio_to_all, times.coarse_ratio_to_ray);
    } else {
      fmt::print(" | | | |");
    }
    fmt::print(" {:.0f} |\n", static_cast<double>(figure.structure_bytes) / (1 << 20));
  }
  const ShadowLightFigure mean = mean_figure(study.figures.front());
  fmt::print("\ntruth: mean visibility {:.3f}, changes by {:.4f} a step\n", mean.truth_visibility,
             mean.truth_change);
}

uint8_t to_byte(float visibility) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(visibility, 0.0f, 1.0f)));
}

constexpr int gap = 4;  ///< between maps, pixels

/// Draws a map of the window into `image`, each pixel `zoom` wide.
void draw_map(const ShadowStudy& study, const std::vector<float>& map, int x0, int y0, int zoom,
              DisplayImage& image) {
  for (int y = 0; y < study.window.height * zoom; ++y) {
    for (int x = 0; x < study.window.width * zoom; ++x) {
      const size_t from = static_cast<size_t>(y / zoom) * study.window.width + x / zoom;
      if (!(study.truth.covered[from] > 0)) continue;
      const size_t to = static_cast<size_t>(y0 + y) * image.width + x0 + x;
      for (int c = 0; c < 3; ++c) image.pixels[3 * to + c] = to_byte(map[from]);
    }
  }
}

/// One row a light: the truth's map and then every figure's, in the table's order.
DisplayImage draw_maps(const ShadowStudy& study) {
  const int zoom = study.window.width <= 128 ? 3 : 1;
  const int columns = static_cast<int>(study.figures.size()) + 1;
  const int width = study.window.width * zoom + gap;
  const int height = study.window.height * zoom + gap;
  DisplayImage image{
      columns * width - gap, static_cast<int>(study.lights.size()) * height - gap, 3, {}};
  image.pixels.assign(static_cast<size_t>(image.width) * image.height * 3, 96);
  for (size_t l = 0; l < study.lights.size(); ++l) {
    const int y0 = static_cast<int>(l) * height;
    draw_map(study, study.truth.steps[l].front(), 0, y0, zoom, image);
    for (size_t f = 0; f < study.figures.size(); ++f) {
      draw_map(study, study.figures[f].lights[l].map, static_cast<int>(f + 1) * width, y0, zoom,
               image);
    }
  }
  return image;
}

}  // namespace

StudyResult run_shadow_study(const StudyOptions& options, const CommonOptions& common,
                             TrialLog& log) {
  StudyResult result{options.name, {{"rows", {}}}, {}, {}};
  std::vector<FigureRow>& rows = result.tables.front().rows;
  const ShadowStudyParams params = make_study_params(options, common);
  for (const std::string& name : options.scenes) {
    const RelightInput input = open_study_scene(name, common);
    const std::string& scene = input.scene->name;
    const SceneCounts counts = count_scene(*input.scene);
    const uint64_t primitives = counts.instanced_triangles + counts.instanced_segments;
    const ShadowStudy study = study_shadows(*input.scene, *input.tracer, params, log,
                                            make_terminal_progress(common.quiet));
    if (!common.json) print_table(scene, study, params);
    for (const ShadowFigure& figure : study.figures) {
      for (const ShadowLightFigure& light : figure.lights) {
        rows.push_back(to_row(scene, figure, light, params, primitives));
      }
      rows.push_back(to_row(scene, figure, mean_figure(figure), params, primitives));
    }
    if (!options.output || !options.pictures) continue;
    const DisplayImage maps = draw_maps(study);
    const std::string file = fmt::format("shadows-{}.png", file_part(scene));
    write_png(*options.output / file, maps);
    result.pictures.push_back({scene, "maps of visibility", "", file, maps.width, maps.height});
  }
  return result;
}

}  // namespace relume

#include "viewer/study/shadow_study.h"

#include <fmt/format.h>

#include <optional>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/image/metrics.h"
#include "core/relight/pixel_visibility.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "viewer/session/method_training.h"
#include "viewer/session/prepare.h"
#include "viewer/study/lit_visibility.h"
#include "viewer/study/shadow_times.h"

namespace relume {
namespace {

/// Added to the seed of the truth, whose samples are others than those of any trial.
constexpr uint64_t truth_seed_offset = 0x7275746800000000u;

/// Sees every light from everywhere.
class NoShadows final : public VisibilitySource {
 public:
  void prepare(const Light&) override {}
  void visibility(const Receivers& receivers, float* visibility) const override {
    std::fill_n(visibility, receivers.count, 1.0f);
  }
};

/// What all trials on a scene share.
struct Setting {
  const Scene& scene;
  const Tracer& tracer;
  const ShadowStudyParams& params;
  ViewSampler view;         ///< at params.spp
  ViewSampler sparse_view;  ///< at one sample a pixel
  StudyWindow window;
};

ReductionParams make_reduction(const Setting& setting, ReductionMethod method, int records) {
  ReductionParams reduction;
  reduction.method = method;
  reduction.records = records;
  reduction.stored_members = max_members;
  reduction.seed = setting.params.seed;
  reduction.scene_radius = std::max(setting.tracer.bounds().radius(), 1e-30f);
  return reduction;
}

CacheInfo make_window_info(const Setting& setting, const ReductionParams& reduction) {
  CacheInfo info;
  info.width = setting.view.width;
  info.height = setting.view.height;
  info.camera = setting.scene.camera;
  info.types = setting.view.types.types;
  info.bounds = setting.tracer.bounds();
  info.method = label_of(reduction_method_labels, reduction.method);
  info.spp = setting.view.strata.spp;
  info.records = reduction.method == ReductionMethod::all ? info.spp : reduction.records;
  info.seed = reduction.seed;
  info.scene_name = setting.scene.name;
  info.scene_file = setting.scene.file.string();
  info.scene_text = setting.scene.text;
  info.lights = setting.scene.lights;
  info.representative_low = setting.scene.representative_low;
  info.representative_high = setting.scene.representative_high;
  return info;
}

/// The records of the window; elsewhere one sample a pixel, so that methods that fit themselves to
/// all receivers do so.
RelightCache prepare_window(const Setting& setting, ReductionMethod method, int records) {
  const ReductionParams reduction = make_reduction(setting, method, records);
  const auto lights =
      make_method_lights(setting.scene, setting.view, reduction, setting.params.training);
  std::vector<PackedTileData> packed(tile_count(setting.view));
  parallel_for(packed.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const TileRectangle place = tile_rectangle(setting.view, static_cast<int>(i));
      const std::vector<SampleType>& types = setting.view.types.types;
      const bool inside = setting.window.contains(place);
      const SampleTile tile =
          sample_tile(inside ? setting.view : setting.sparse_view, static_cast<int>(i));
      const SampleTile reduced =
          reduce_tile(tile, types, reduction, setting.view.width, lights->lights());
      packed[i] = pack_tile(reduced, types, {CacheFormat::exact, setting.scene.camera});
    }
  });
  CacheWriter writer;
  for (const PackedTileData& tile : packed) writer.add(tile);
  writer.finish(make_window_info(setting, reduction));
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), setting.scene.name);
}

std::vector<float> crop(std::span<const float> values, int channels, int width,
                        const StudyWindow& window) {
  std::vector<float> part;
  for (int y = window.y0; y < window.y0 + window.height; ++y) {
    const auto row = values.begin() + (std::ptrdiff_t{y} * width + window.x0) * channels;
    part.insert(part.end(), row, row + std::ptrdiff_t{window.width} * channels);
  }
  return part;
}

std::vector<float> window_visibility(const Setting& setting, const RelightCache& cache,
                                     VisibilitySource* source, const Light& light) {
  static const NoShadows no_shadows;
  if (source != nullptr) source->prepare(light);
  const VisibilitySource* shown = source;
  if (shown == nullptr) shown = &no_shadows;
  return crop(pixel_visibility(cache, LitVisibility(*shown, light)), 1, cache.info().width,
              setting.window);
}

Image window_frame(const Setting& setting, const RelightCache& cache, VisibilitySource* source,
                   const Light& light) {
  RelightState state = make_relight_state(cache);
  relight(state, {&light, 1}, source);
  Image image(setting.window.width, setting.window.height);
  image.pixels = crop(state.frame.pixels, 3, state.frame.width, setting.window);
  return image;
}

/// Mean |change of the maps - change of the truth| over the steps.
double measure_flicker(const std::vector<std::vector<float>>& maps,
                       const std::vector<std::vector<float>>& truth,
                       const std::vector<float>& covered) {
  double sum = 0;
  for (size_t step = 1; step < truth.size(); ++step) {
    std::vector<float> change(covered.size());
    std::vector<float> truth_change(covered.size());
    for (size_t i = 0; i < covered.size(); ++i) {
      change[i] = maps.empty() ? 0.0f : maps[step][i] - maps[step - 1][i];
      truth_change[i] = truth[step][i] - truth[step - 1][i];
    }
    sum += mean_absolute_difference(change, truth_change, covered);
  }
  return truth.size() > 1 ? sum / static_cast<double>(truth.size() - 1) : 0;
}

double mean_over(const std::vector<float>& values, const std::vector<float>& covered) {
  return mean_absolute_difference(values, std::vector<float>(values.size(), 0.0f), covered);
}

/// Frames of the trial that all others are held against, by light.
using ReferenceFrames = std::vector<Image>;

ShadowLightFigure measure_light(const Setting& setting, const ShadowStudy& study, size_t l,
                                const RelightCache& cache, VisibilitySource* source,
                                const ReferenceFrames& reference, Image& frame) {
  const StudyLight& light = study.lights[l];
  const ShadowTruth& truth = study.truth;
  ShadowLightFigure figure;
  figure.light = light.name;
  frame = window_frame(setting, cache, source, light.path.front());
  std::vector<std::vector<float>> maps;
  for (const Light& place : light.path) {
    maps.push_back(window_visibility(setting, cache, source, place));
  }
  figure.truth_visibility = mean_over(truth.steps[l].front(), truth.covered);
  figure.visibility =
      compare_visibility(maps.front(), truth.steps[l].front(), truth.covered, setting.window.width);
  figure.flicker = measure_flicker(maps, truth.steps[l], truth.covered);
  figure.truth_change = measure_flicker({}, truth.steps[l], truth.covered);
  const ImageError error = compare_images(frame, truth.frames[l], truth.covered);
  figure.error = error.error_covered;
  figure.reference_mean = error.reference_mean;
  if (!reference.empty()) {
    figure.error_of_all = compare_images(frame, reference[l], truth.covered).error_covered;
  }
  if (setting.params.keep_maps) figure.map = std::move(maps.front());
  return figure;
}

ShadowFigure measure_trial(const Setting& setting, const ShadowStudy& study,
                           const RelightCache& cache, const ShadowTrial& trial,
                           ReferenceFrames& reference) {
  ShadowFigure figure;
  figure.trial = trial;
  const double covered =
      mean_over(study.truth.covered, std::vector<float>(study.truth.covered.size(), 1.0f)) *
      static_cast<double>(study.truth.covered.size());
  double records = 0;
  for (const float count : crop(cache.record_counts(), 1, cache.info().width, setting.window)) {
    records += count;
  }
  figure.average_records = records / std::max(1.0, covered);
  const auto source = make_shadow(trial.shadow, setting.tracer, cache);
  ReferenceFrames frames(study.lights.size());
  for (size_t l = 0; l < study.lights.size(); ++l) {
    figure.lights.push_back(
        measure_light(setting, study, l, cache, source.get(), reference, frames[l]));
  }
  if (reference.empty()) reference = std::move(frames);
  const bool is_traced = trial.shadow == ShadowMethod::ray || trial.shadow == ShadowMethod::members;
  if (source != nullptr) {
    figure.structure_bytes =
        is_traced ? setting.tracer.stats().memory_bytes : source->memory_bytes();
  }
  return figure;
}

/// All samples, each with its ray: the trial that all others are held against.
ReferenceFrames make_reference(const Setting& setting, const ShadowStudy& study) {
  const RelightCache cache = prepare_window(setting, ReductionMethod::all, setting.params.spp);
  const auto source = make_shadow(ShadowMethod::ray, setting.tracer, cache);
  ReferenceFrames frames;
  for (const StudyLight& light : study.lights) {
    frames.push_back(window_frame(setting, cache, source.get(), light.path.front()));
  }
  return frames;
}

/// A trial's place in the log.
std::string name_trial(const Setting& setting, const ShadowTrial& trial) {
  return fmt::format("{}: {} {} {}", setting.scene.name,
                     label_of(reduction_method_labels, trial.method), trial.records,
                     label_of(shadow_method_labels, trial.shadow));
}

/// Calls visit(number) for all that a trial measured but its times and maps.
template <class Visit>
void visit_figure(ShadowFigure& figure, const Visit& visit) {
  visit(figure.average_records);
  for (ShadowLightFigure& light : figure.lights) {
    for (double* number : {&light.truth_visibility, &light.visibility.mae, &light.visibility.bias,
                           &light.visibility.noise, &light.flicker, &light.truth_change,
                           &light.error, &light.error_of_all, &light.reference_mean}) {
      visit(*number);
    }
  }
}

/// The structure's bytes, the numbers and the maps, as the log keeps them.
std::vector<double> to_values(ShadowFigure figure) {
  std::vector<double> values{static_cast<double>(figure.structure_bytes)};
  visit_figure(figure, [&](double number) { values.push_back(number); });
  for (const ShadowLightFigure& light : figure.lights) {
    values.insert(values.end(), light.map.begin(), light.map.end());
  }
  return values;
}

ShadowFigure to_figure(const Setting& setting, const ShadowStudy& study, const ShadowTrial& trial,
                       const std::vector<double>& values) {
  ShadowFigure figure;
  figure.trial = trial;
  figure.structure_bytes = static_cast<uint64_t>(values[0]);
  figure.lights.resize(study.lights.size());
  size_t at = 1;
  visit_figure(figure, [&](double& number) { number = values[at++]; });
  const size_t map_size = setting.params.keep_maps ? study.truth.covered.size() : 0;
  CHECK_MSG(values.size() == at + map_size * figure.lights.size(), "{} {}", values.size(), at);
  for (size_t l = 0; l < figure.lights.size(); ++l) {
    figure.lights[l].light = study.lights[l].name;
    const auto first = values.begin() + static_cast<std::ptrdiff_t>(at + l * map_size);
    figure.lights[l].map.assign(first, first + static_cast<std::ptrdiff_t>(map_size));
  }
  return figure;
}

/// Which records a trial asks for.
using RecordKey = std::pair<ReductionMethod, int>;

RecordKey key_of(const ShadowTrial& trial) {
  return {trial.method, trial.method == ReductionMethod::all ? 0 : trial.records};
}

/// Times of light moves on whole pictures, out of the log where it holds them.
class MoveTimes {
 public:
  MoveTimes(const Setting& setting, const StudyLight& light, TrialLog& log,
            ProgressCallback progress)
      : setting_(setting), light_(light), log_(log), progress_(std::move(progress)) {}

  ShadowTimes get(const ShadowTrial& trial) {
    if (trial.shadow == ShadowMethod::none) return {};
    const std::string key = name_trial(setting_, trial) + ", times";
    const std::vector<double>* values = log_.find(key);
    if (values == nullptr) {
      const ShadowTimes times = time_moves(setting_.tracer, records(trial), light_, trial.shadow,
                                           setting_.params.repeats);
      values =
          &log_.add(key, {times.ms_prepare, times.ms_move, times.ms_coarse, times.records_per_s});
    }
    CHECK_MSG(values->size() == 4, "{}", values->size());
    ShadowTimes times;
    times.ms_prepare = (*values)[0];
    times.ms_move = (*values)[1];
    times.ms_coarse = (*values)[2];
    times.records_per_s = (*values)[3];
    return times;
  }

 private:
  const RelightCache& records(const ShadowTrial& trial) {
    if (cache_ && cached_ == key_of(trial)) return *cache_;
    PrepareParams prepare;
    prepare.spp = setting_.params.spp;
    prepare.width = setting_.view.width;
    prepare.height = setting_.view.height;
    prepare.training = setting_.params.training;
    prepare.reduction = make_reduction(setting_, trial.method, trial.records);
    cache_.reset();
    cache_ = prepare_in_memory(setting_.scene, setting_.tracer, prepare, progress_);
    cached_ = key_of(trial);
    return *cache_;
  }

  const Setting& setting_;
  const StudyLight& light_;
  TrialLog& log_;
  ProgressCallback progress_;
  std::optional<RelightCache> cache_;
  RecordKey cached_{};
};

/// Times the trials of all samples and those with the first trial's reduction.
void time_trials(const Setting& setting, ShadowStudy& study, TrialLog& log,
                 const ProgressCallback& progress) {
  const ReductionMethod timed_method = setting.params.trials.front().method;
  MoveTimes moves(setting, study.lights.front(), log, progress);
  const double all_ms = moves.get(study.figures.front().trial).ms_move;
  for (ShadowFigure& figure : study.figures) {
    const ShadowTrial& trial = figure.trial;
    if (trial.method != ReductionMethod::all && trial.method != timed_method) continue;
    const double ray_ms = moves.get({ShadowMethod::ray, trial.method, trial.records}).ms_move;
    figure.times = moves.get(trial);
    figure.times.ratio_to_ray = figure.times.ms_move / ray_ms;
    figure.times.coarse_ratio_to_ray = figure.times.ms_coarse / ray_ms;
    figure.times.ratio_to_all = figure.times.ms_move / all_ms;
  }
}

/// The trials, with all samples traced as the first and trials of the same records in a row.
std::vector<ShadowTrial> order_trials(const ShadowStudyParams& params) {
  std::vector<ShadowTrial> trials{{ShadowMethod::ray, ReductionMethod::all, params.spp}};
  for (const ShadowTrial& trial : params.trials) {
    if (trial.shadow == ShadowMethod::ray && trial.method == ReductionMethod::all) continue;
    trials.push_back(trial);
  }
  std::vector<RecordKey> order;
  for (const ShadowTrial& trial : trials) {
    if (std::ranges::find(order, key_of(trial)) == order.end()) order.push_back(key_of(trial));
  }
  std::ranges::stable_sort(trials, [&](const ShadowTrial& a, const ShadowTrial& b) {
    return std::ranges::find(order, key_of(a)) < std::ranges::find(order, key_of(b));
  });
  return trials;
}

void measure_trials(const Setting& setting, ShadowStudy& study, TrialLog& log,
                    const ProgressCallback& callback) {
  const std::vector<ShadowTrial> trials = order_trials(setting.params);
  Progress progress(callback, "study shadows of " + setting.scene.name);
  ReferenceFrames reference;
  std::optional<RelightCache> cache;
  RecordKey cached{};
  for (size_t i = 0; i < trials.size(); ++i) {
    const std::string key = name_trial(setting, trials[i]);
    if (const std::vector<double>* known = log.find(key)) {
      study.figures.push_back(to_figure(setting, study, trials[i], *known));
      continue;
    }
    if (i > 0 && reference.empty()) reference = make_reference(setting, study);
    if (!cache || key_of(trials[i]) != cached) {
      cache.reset();
      cache = prepare_window(setting, trials[i].method, trials[i].records);
      cached = key_of(trials[i]);
    }
    study.figures.push_back(measure_trial(setting, study, *cache, trials[i], reference));
    log.add(key, to_values(study.figures.back()));
    progress.update(static_cast<double>(i + 1), static_cast<double>(trials.size()));
  }
}

}  // namespace

ShadowLightFigure mean_figure(const ShadowFigure& figure) {
  ShadowLightFigure mean;
  mean.light = "mean";
  const double scale = 1.0 / static_cast<double>(std::max<size_t>(1, figure.lights.size()));
  for (const ShadowLightFigure& light : figure.lights) {
    mean.truth_visibility += scale * light.truth_visibility;
    mean.visibility.mae += scale * light.visibility.mae;
    mean.visibility.bias += scale * light.visibility.bias;
    mean.visibility.noise += scale * light.visibility.noise;
    mean.flicker += scale * light.flicker;
    mean.truth_change += scale * light.truth_change;
    mean.error += scale * light.error;
    mean.error_of_all += scale * light.error_of_all;
    mean.reference_mean += scale * light.reference_mean;
  }
  return mean;
}

ShadowStudy study_shadows(const Scene& scene, const Tracer& tracer, const ShadowStudyParams& params,
                          TrialLog& log, const ProgressCallback& callback) {
  CHECK_MSG(params.spp >= 1 && params.truth_spp >= 1 && params.steps >= 0 && params.repeats >= 1,
            "{} {} {} {}", params.spp, params.truth_spp, params.steps, params.repeats);
  CHECK_MSG(!has_emission(scene), "{} emits light", scene.name);
  const int width = params.width > 0 ? params.width : scene.width;
  const int height = params.height > 0 ? params.height : scene.height;
  const ViewFocus focus = find_focus(scene, tracer, width, height);
  ShadowStudy study;
  study.lights = make_study_lights(scene, focus, params.steps);
  study.window = make_window(params.window, 0.5f * vec2(width, height), width, height);
  const Setting setting{scene,
                        tracer,
                        params,
                        make_view_sampler(scene, tracer, width, height, params.spp, params.seed),
                        make_view_sampler(scene, tracer, width, height, 1, params.seed),
                        study.window};
  study.truth = trace_truth(make_view_sampler(scene, tracer, width, height, params.truth_spp,
                                              params.seed + truth_seed_offset),
                            study.window, study.lights, log, callback);
  measure_trials(setting, study, log, callback);
  if (params.timed) time_trials(setting, study, log, callback);
  return study;
}

}  // namespace relume

#include "viewer/study/shadow_study.h"

#include <optional>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/image/metrics.h"
#include "core/relight/pixel_visibility.h"
#include "core/relight/receivers.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "viewer/session/method_training.h"
#include "viewer/session/prepare.h"
#include "viewer/study/lit_visibility.h"

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

/// Asks for the records of the pixels that coarse frames shade.
void query_coarse(const RelightCache& cache, const VisibilitySource& source) {
  const BlockDecoder decoder(cache, InstructionSet::automatic);
  const auto tiles = cache.tiles();
  parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
    std::vector<float> scratch;
    std::vector<float> visibility;
    for (size_t t = begin; t < end; ++t) {
      size_t first = tiles[t].first_slot * block_lanes;
      const int blocks = cache.block_count(tiles[t], PixelShare::quarter);
      for (int b = 0; b < blocks; ++b) {
        const PackedBlock block = cache.block(tiles[t], b);
        query_block(cache.info(), block, decoder.floats(block, scratch), first, source, visibility);
        first += visibility.size();
      }
    }
  });
}

/// Least time of a move of the first light on all records of `cache`.
ShadowTimes time_trial(const Setting& setting, const RelightCache& cache, const StudyLight& light,
                       ShadowMethod shadow) {
  const auto source = make_shadow(shadow, setting.tracer, cache);
  ShadowTimes times;
  if (source == nullptr) return times;
  times.ms_move = std::numeric_limits<double>::infinity();
  for (int i = 0; i < setting.params.repeats; ++i) {
    const Timer timer;
    source->prepare(light.path[static_cast<size_t>(i) % light.path.size()]);
    const double prepared_ms = timer.ms();
    query_cache(cache, *source);
    const double ms = timer.ms();
    if (ms >= times.ms_move) continue;
    times.ms_move = ms;
    times.ms_prepare = prepared_ms;
  }
  // A coarse frame asks for a quarter of the pixels, unless prepare() answers for all.
  times.ms_coarse = times.ms_move;
  if (source->all_visibility().empty()) {
    double look_up_ms = std::numeric_limits<double>::infinity();
    for (int i = 0; i < setting.params.repeats; ++i) {
      const Timer timer;
      query_coarse(cache, *source);
      look_up_ms = std::min(look_up_ms, timer.ms());
    }
    times.ms_coarse = times.ms_prepare + look_up_ms;
  }
  times.records_per_s = static_cast<double>(cache.info().record_count) / (times.ms_move * 1e-3);
  return times;
}

/// Which records a trial asks for.
using RecordKey = std::pair<ReductionMethod, int>;

RecordKey key_of(const ShadowTrial& trial) {
  return {trial.method, trial.method == ReductionMethod::all ? 0 : trial.records};
}

/// Times the trials of all samples and those with the first trial's reduction, on whole pictures.
void time_trials(const Setting& setting, ShadowStudy& study, const ProgressCallback& progress) {
  const ReductionMethod timed_method = setting.params.trials.front().method;
  ShadowTimes ray;
  double all_ms = 0;
  std::optional<RelightCache> cache;
  std::optional<RecordKey> cached;
  for (ShadowFigure& figure : study.figures) {
    const bool is_all = figure.trial.method == ReductionMethod::all;
    if (!is_all && figure.trial.method != timed_method) continue;
    const RecordKey key = key_of(figure.trial);
    if (cached != key) {
      PrepareParams prepare;
      prepare.spp = setting.params.spp;
      prepare.width = setting.view.width;
      prepare.height = setting.view.height;
      prepare.training = setting.params.training;
      prepare.reduction = make_reduction(setting, figure.trial.method, figure.trial.records);
      cache.reset();
      cache = prepare_in_memory(setting.scene, setting.tracer, prepare, progress);
      cached = key;
      ray = time_trial(setting, *cache, study.lights.front(), ShadowMethod::ray);
      if (is_all) all_ms = ray.ms_move;
    }
    const bool is_ray = figure.trial.shadow == ShadowMethod::ray;
    figure.times =
        is_ray ? ray : time_trial(setting, *cache, study.lights.front(), figure.trial.shadow);
    figure.times.ratio_to_ray = figure.times.ms_move / ray.ms_move;
    figure.times.coarse_ratio_to_ray = figure.times.ms_coarse / ray.ms_move;
    figure.times.ratio_to_all = all_ms > 0 ? figure.times.ms_move / all_ms : 0;
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
                          const ProgressCallback& callback) {
  CHECK_MSG(params.spp >= 1 && params.truth_spp >= 1 && params.steps >= 0 && params.repeats >= 1,
            "{} {} {} {}", params.spp, params.truth_spp, params.steps, params.repeats);
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
                            study.window, study.lights, callback);
  const std::vector<ShadowTrial> trials = order_trials(params);
  Progress progress(callback, "study shadows of " + scene.name);
  ReferenceFrames reference;
  std::optional<RelightCache> cache;
  for (size_t i = 0; i < trials.size(); ++i) {
    if (i == 0 || key_of(trials[i]) != key_of(trials[i - 1])) {
      cache.reset();
      cache = prepare_window(setting, trials[i].method, trials[i].records);
    }
    study.figures.push_back(measure_trial(setting, study, *cache, trials[i], reference));
    progress.update(static_cast<double>(i + 1), static_cast<double>(trials.size()));
  }
  if (params.timed) time_trials(setting, study, callback);
  return study;
}

}  // namespace relume

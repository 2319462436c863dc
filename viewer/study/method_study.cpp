#include "viewer/study/method_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "viewer/session/method_training.h"
#include "viewer/session/record_planning.h"
#include "viewer/study/ray_memory.h"
#include "viewer/study/significance.h"
#include "viewer/study/tile_values.h"

namespace relume {
namespace {

/// Tiles between two entries of the log and two reports of progress.
constexpr size_t batch_tiles = 32;

/// Added to the seed of a reference whose samples are others than those of any trial.
constexpr uint64_t reference_seed_offset = 0x7275746800000000u;

/// One trial made ready for a scene.
struct Runner {
  MethodTrial trial;
  ReductionParams params;
  ViewSampler view;
  std::unique_ptr<const MethodLights> lights;
  /// Where the method is trained with shadows: the lights, for a training set of each tile's own.
  std::vector<Light> shadowed_training;
};

bool is_reduced(ReductionMethod method) {
  return method != ReductionMethod::all && method != ReductionMethod::pure;
}

/// What all trials on a scene share.
struct Setting {
  const Scene& scene;
  const Tracer& tracer;
  const MethodStudyParams& params;
  int width;
  int height;
  float scene_radius;
  ViewSampler reference_view;
  TestLights lights;
  RayTargets targets;  ///< every light that a shadow ray is asked for

  bool asks_for(ShadowMethod shadow) const {
    return std::ranges::find(params.shadows, shadow) != params.shadows.end();
  }
  const std::vector<SampleType>& types() const { return reference_view.types.types; }
};

/// Sums over tiles, in the shape in which the log keeps them.
class BatchSums {
 public:
  static constexpr size_t head = 2;        ///< pixels, covered pixels
  static constexpr size_t trial_head = 3;  ///< records, predicted error, milliseconds of reduction

  explicit BatchSums(const MethodStudyParams& params)
      : shadows_(params.shadows.size()), lights_(params.lights) {
    values_.assign(head + shadows_ + params.trials.size() * trial_size(), 0.0);
  }

  double& pixels() { return values_[0]; }
  double& covered() { return values_[1]; }
  double& reference(size_t shadow) { return values_[head + shadow]; }
  double* trial(size_t index) { return &values_[head + shadows_ + index * trial_size()]; }
  double* errors(size_t index, size_t shadow) {
    return trial(index) + trial_head + shadow * lights_;
  }

  void add(std::span<const double> values) {
    CHECK_MSG(values.size() == values_.size(), "{} {}", values.size(), values_.size());
    for (size_t i = 0; i < values_.size(); ++i) values_[i] += values[i];
  }
  const std::vector<double>& values() const { return values_; }

 private:
  size_t trial_size() const { return trial_head + shadows_ * lights_; }

  size_t shadows_;
  size_t lights_;
  std::vector<double> values_;
};

TrainingParams training_of(const MethodStudyParams& params, const MethodTrial& trial) {
  TrainingParams training = params.training;
  if (trial.training_lights > 0) training.lights = trial.training_lights;
  training.shadows |= trial.train_shadows;
  training.shadows &= needs_training(trial.method) && !is_light_fit(trial.method);
  return training;
}

RayTargets make_targets(const Scene& scene, const Tracer& tracer, const MethodStudyParams& params,
                        std::span<const Light> test_lights) {
  RayTargets targets(tracer);
  for (const Light& light : test_lights) targets.add(light);
  for (const MethodTrial& trial : params.trials) {
    const TrainingParams training = training_of(params, trial);
    if (!training.shadows) continue;
    for (const Light& light :
         make_training_lights(scene.representative_low, scene.representative_high, training)) {
      targets.add(light);
    }
  }
  return targets;
}

Setting make_setting(const Scene& scene, const Tracer& tracer, const MethodStudyParams& params) {
  const int width = params.width > 0 ? params.width : scene.width;
  const int height = params.height > 0 ? params.height : scene.height;
  const float radius = std::max(tracer.bounds().radius(), 1e-30f);
  ViewSampler view =
      make_view_sampler(scene, tracer, width, height, params.reference_spp,
                        params.is_independent ? params.seed + reference_seed_offset : params.seed);
  std::vector<Light> lights;
  for (int i = 0; i < params.lights; ++i) {
    lights.push_back(interpolate_light(scene.representative_low, scene.representative_high,
                                       params.seed, static_cast<uint64_t>(i)));
  }
  TestLights test = make_test_lights(lights, view, radius);
  return {scene,           tracer,          params,
          width,           height,          radius,
          std::move(view), std::move(test), make_targets(scene, tracer, params, lights)};
}

Runner make_runner(const Setting& setting, const MethodTrial& trial,
                   const ProgressCallback& progress) {
  const MethodStudyParams& params = setting.params;
  const int spp = trial.method == ReductionMethod::pure ? trial.records : trial.spp;
  Runner runner{trial,
                {},
                make_view_sampler(setting.scene, setting.tracer, setting.width, setting.height, spp,
                                  params.seed),
                nullptr,
                {}};
  runner.params.method = trial.method;
  runner.params.records = trial.records;
  runner.params.seed = params.seed;
  runner.params.scene_radius = setting.scene_radius;
  if (!is_reduced(trial.method)) return runner;
  if (trial.budget.is_set()) {
    runner.params.record_cost = plan_records(setting.scene, runner.view, runner.params,
                                             params.training, trial.budget, progress)
                                    .record_cost;
  }
  TrainingParams training = training_of(params, trial);
  if (training.shadows) {
    runner.shadowed_training = make_training_lights(setting.scene.representative_low,
                                                    setting.scene.representative_high, training);
    training.shadows = false;
  }
  runner.lights = make_method_lights(setting.scene, runner.view, runner.params, training);
  return runner;
}

/// Per light, eq. 7 before the mean: the sum over pixels of the RMS over RGB.
void add_errors(std::span<const float> values, std::span<const float> reference, size_t lights,
                double* errors) {
  for (size_t pixel = 0; pixel < values.size(); pixel += 3 * lights) {
    for (size_t light = 0; light < lights; ++light) {
      double squares = 0;
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = pixel + c * lights + light;
        const double d = double{values[i]} - reference[i];
        squares += d * d;
      }
      errors[light] += std::sqrt(squares / 3);
    }
  }
}

std::span<const float> values_of(const TileValues& values, ShadowMethod shadow) {
  return shadow == ShadowMethod::none ? values.plain : values.traced;
}

int64_t count_covered(const SampleTile& tile) {
  int64_t covered = 0;
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    const auto has_rows = [&](const TypedRows& rows) {
      return rows.first[pixel + 1] > rows.first[pixel];
    };
    if (std::ranges::any_of(tile.types, has_rows)) ++covered;
  }
  return covered;
}

/// One tile under the test lights.
TileValues look_at(const Setting& setting, const SampleTile& rows, const RayMemory& memory) {
  const std::vector<const VisibilitySource*> shadows = memory.sources(*setting.lights.set.lights);
  return tile_values(
      rows, setting.types(), setting.lights,
      setting.asks_for(ShadowMethod::ray) ? shadows : std::span<const VisibilitySource* const>());
}

SampleTile make_records(const Setting& setting, const Runner& runner, const SampleTile& samples,
                        const RayMemory& memory) {
  if (!is_reduced(runner.trial.method)) return samples;
  ReductionLights lights = runner.lights->lights();
  std::optional<TrainingSet> shadowed;
  if (!runner.shadowed_training.empty()) {
    shadowed = make_training_set(runner.shadowed_training, setting.types(), runner.view.rays.eye(),
                                 setting.scene_radius);
    shadowed->visibility = memory.sources(*shadowed->lights);
    lights.training = &*shadowed;
  }
  return reduce_tile(samples, setting.types(), runner.params, runner.view.width, lights);
}

void measure_trial(const Setting& setting, const Runner& runner, const SampleTile& samples,
                   const TileValues& reference, const RayMemory& memory, size_t index,
                   BatchSums& sums) {
  double* const head = sums.trial(index);
  const Timer timer;
  const SampleTile records = make_records(setting, runner, samples, memory);
  head[2] = timer.ms();
  head[0] = static_cast<double>(records.row_count());
  for (const float error : records.predicted_error) head[1] += error;
  const TileValues values = look_at(setting, records, memory);
  for (size_t s = 0; s < setting.params.shadows.size(); ++s) {
    const ShadowMethod shadow = setting.params.shadows[s];
    add_errors(values_of(values, shadow), values_of(reference, shadow), setting.lights.count(),
               sums.errors(index, s));
  }
}

BatchSums measure_tile(const Setting& setting, std::span<const Runner> runners, int tile) {
  BatchSums sums(setting.params);
  const SampleTile reference_samples = sample_tile(setting.reference_view, tile);
  const RayMemory memory(setting.targets);
  const TileValues reference = look_at(setting, reference_samples, memory);
  for (size_t s = 0; s < setting.params.shadows.size(); ++s) {
    for (const float value : values_of(reference, setting.params.shadows[s])) {
      sums.reference(s) += value;
    }
  }
  sums.pixels() = reference_samples.pixel_count();
  sums.covered() = static_cast<double>(count_covered(reference_samples));
  SampleTile samples;
  int spp = 0;
  for (size_t i = 0; i < runners.size(); ++i) {
    const ViewSampler& view = runners[i].view;
    if (spp != view.strata.spp) samples = sample_tile(view, tile);
    spp = view.strata.spp;
    measure_trial(setting, runners[i], samples, reference, memory, i, sums);
  }
  return sums;
}

/// Merged in the order of the tiles, so that threads do not change the sums.
BatchSums measure_batch(const Setting& setting, std::span<const Runner> runners,
                        std::span<const int> tiles) {
  std::vector<BatchSums> results(tiles.size(), BatchSums(setting.params));
  parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) results[i] = measure_tile(setting, runners, tiles[i]);
  });
  BatchSums sums(setting.params);
  for (const BatchSums& tile : results) sums.add(tile.values());
  return sums;
}

/// Every n-th tile from a random start.
std::vector<int> choose_tiles(const Setting& setting) {
  const MethodStudyParams& params = setting.params;
  std::vector<int> tiles;
  Random random(params.seed, RandomStream::planning, ~uint64_t{0});
  for (int i = static_cast<int>(random.below(static_cast<uint32_t>(params.tile_stride)));
       i < tile_count(setting.reference_view); i += params.tile_stride) {
    tiles.push_back(i);
  }
  return tiles;
}

BatchSums measure_all(const Setting& setting, TrialLog& log, const ProgressCallback& callback) {
  const std::vector<int> tiles = choose_tiles(setting);
  std::vector<std::string> keys;
  for (size_t first = 0; first < tiles.size(); first += batch_tiles) {
    keys.push_back(fmt::format("{} tiles from {}", setting.scene.name, first));
  }
  std::vector<Runner> runners;  // made when the first batch needs them
  const auto measure = [&](size_t batch) {
    for (size_t i = runners.size(); i < setting.params.trials.size(); ++i) {
      runners.push_back(make_runner(setting, setting.params.trials[i], callback));
    }
    const size_t first = batch * batch_tiles;
    const auto part = std::span(tiles).subspan(first, std::min(batch_tiles, tiles.size() - first));
    return measure_batch(setting, runners, part).values();
  };
  log.complete("study " + setting.scene.name, keys, measure, callback);
  BatchSums total(setting.params);
  for (const std::string& key : keys) total.add(*log.find(key));
  return total;
}

MethodFigure make_figure(const MethodStudyParams& params, BatchSums& sums, size_t trial,
                         size_t shadow) {
  const double covered = std::max(1.0, sums.covered());
  const double* const head = sums.trial(trial);
  MethodFigure figure;
  figure.trial = params.trials[trial];
  figure.shadow = params.shadows[shadow];
  for (int light = 0; light < params.lights; ++light) {
    figure.errors.push_back(sums.errors(trial, shadow)[light] / covered);
  }
  const MeanInterval interval = mean_interval(figure.errors);
  figure.error = interval.mean;
  figure.error_stddev = interval.stddev;
  figure.error_half_95 = interval.half_95;
  figure.error_image = figure.error * sums.covered() / std::max(1.0, sums.pixels());
  figure.reference_mean = sums.reference(shadow) / (3 * params.lights * covered);
  figure.average_records = head[0] / covered;
  figure.predicted_error = head[1] / covered;
  figure.thread_ms_reduce = head[2];
  figure.covered_pixels = static_cast<int64_t>(sums.covered());
  return figure;
}

}  // namespace

std::vector<MethodFigure> study_methods(const Scene& scene, const Tracer& tracer,
                                        const MethodStudyParams& params, TrialLog& log,
                                        const ProgressCallback& progress) {
  CHECK_MSG(params.lights >= 1 && params.tile_stride >= 1 && !params.trials.empty() &&
                !params.shadows.empty(),
            "lights {} stride {}", params.lights, params.tile_stride);
  const Setting setting = make_setting(scene, tracer, params);
  BatchSums sums = measure_all(setting, log, progress);
  std::vector<MethodFigure> figures;
  for (size_t trial = 0; trial < params.trials.size(); ++trial) {
    for (size_t shadow = 0; shadow < params.shadows.size(); ++shadow) {
      figures.push_back(make_figure(params, sums, trial, shadow));
    }
  }
  return figures;
}

}  // namespace relume

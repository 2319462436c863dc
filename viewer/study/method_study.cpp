#include "viewer/study/method_study.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "viewer/session/method_training.h"
#include "viewer/session/record_planning.h"

namespace relume {
namespace {

/// Tiles between two reports of progress.
constexpr size_t batch_tiles = 32;

/// Added to the seed of a reference whose samples are others than those of any trial.
constexpr uint64_t reference_seed_offset = 0x7275746800000000u;

/// What a tile's pixels look like under the test lights: pixels x 3 x columns.
std::vector<float> tile_values(const SampleTile& tile, const LobeEvaluator& evaluator) {
  const auto columns = static_cast<size_t>(evaluator.lights().columns());
  std::vector<float> values(static_cast<size_t>(tile.pixel_count()) * 3 * columns, 0.0f);
  std::vector<float> lobes(max_lobes * columns);
  std::vector<float> v(3 * columns);
  for (size_t t = 0; t < tile.types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const int type = static_cast<int>(t);
    const auto width = static_cast<size_t>(evaluator.vector_width(type));
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      float* out = &values[static_cast<size_t>(pixel) * 3 * columns];
      for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
        const float* vector = &rows.values[row * width];
        evaluator.lobes(type, vector, lobes.data());
        shade_rows(evaluator, type, vector, 1, lobes.data(), v.data());
        for (size_t i = 0; i < v.size(); ++i) out[i] += rows.weights[row] * v[i];
      }
    }
  }
  return values;
}

/// Sums over one tile; merged in tile order, so that threads do not change them.
struct TileSums {
  std::vector<double> errors;  ///< per light
  double predicted = 0;
  int64_t records = 0;
  double reduce_ms = 0;
};

struct TileResult {
  std::vector<TileSums> trials;
  double reference = 0;  ///< over pixels, lights and RGB
  int64_t covered = 0;
  int64_t pixels = 0;
};

/// One trial made ready for a scene.
struct Runner {
  MethodTrial trial;
  ReductionParams params;
  ViewSampler view;
  std::unique_ptr<const MethodLights> lights;
};

bool is_reduced(ReductionMethod method) {
  return method != ReductionMethod::all && method != ReductionMethod::pure;
}

Runner make_runner(const Scene& scene, const Tracer& tracer, const MethodStudyParams& params,
                   const MethodTrial& trial, int width, int height,
                   const ProgressCallback& progress) {
  const int spp = trial.method == ReductionMethod::pure ? trial.records : trial.spp;
  Runner runner{
      trial, {}, make_view_sampler(scene, tracer, width, height, spp, params.seed), nullptr};
  runner.params.method = trial.method;
  runner.params.records = trial.records;
  runner.params.seed = params.seed;
  runner.params.scene_radius = std::max(tracer.bounds().radius(), 1e-30f);
  if (!is_reduced(trial.method)) return runner;
  if (trial.budget.is_set()) {
    runner.params.record_cost =
        plan_records(scene, runner.view, runner.params, params.training, trial.budget, progress)
            .record_cost;
  }
  runner.lights = make_method_lights(scene, runner.view, runner.params, params.training);
  return runner;
}

TileSums measure_trial(const Runner& runner, const SampleTile& samples,
                       const LobeEvaluator& evaluator, const std::vector<float>& reference,
                       int lights) {
  TileSums sums;
  const Timer timer;
  const SampleTile records = is_reduced(runner.trial.method)
                                 ? reduce_tile(samples, runner.view.types.types, runner.params,
                                               runner.view.width, runner.lights->lights())
                                 : samples;
  sums.reduce_ms = timer.ms();
  sums.records = static_cast<int64_t>(records.row_count());
  for (const float error : records.predicted_error) sums.predicted += error;
  const std::vector<float> values = tile_values(records, evaluator);
  const auto columns = static_cast<size_t>(evaluator.lights().columns());
  std::vector<double> errors(columns, 0.0);
  for (size_t pixel = 0; pixel < static_cast<size_t>(samples.pixel_count()); ++pixel) {
    for (size_t j = 0; j < columns; ++j) {
      double squares = 0;
      for (size_t c = 0; c < 3; ++c) {
        const size_t i = (pixel * 3 + c) * columns + j;
        const double d = double{values[i]} - reference[i];
        squares += d * d;
      }
      errors[j] += std::sqrt(squares / 3);
    }
  }
  // Padding columns have weight 0, and so no error; the lights come first within each kind.
  for (size_t j = 0; j < columns; ++j) {
    if (evaluator.lights().padding[j]) continue;
    sums.errors.push_back(errors[j]);
  }
  CHECK_MSG(sums.errors.size() == static_cast<size_t>(lights), "{} {}", sums.errors.size(), lights);
  return sums;
}

TileResult measure_tile(std::span<const Runner> runners, const ViewSampler& reference_view,
                        int index, const LobeEvaluator& evaluator, int lights) {
  TileResult result;
  const SampleTile reference_samples = sample_tile(reference_view, index);
  const std::vector<float> reference = tile_values(reference_samples, evaluator);
  for (const float value : reference) result.reference += value;
  result.pixels = reference_samples.pixel_count();
  for (int pixel = 0; pixel < reference_samples.pixel_count(); ++pixel) {
    const auto has_rows = [&](const TypedRows& rows) {
      return rows.first[pixel + 1] > rows.first[pixel];
    };
    if (std::ranges::any_of(reference_samples.types, has_rows)) ++result.covered;
  }
  SampleTile samples;
  int spp = 0;
  for (const Runner& runner : runners) {
    if (spp != runner.view.strata.spp) samples = sample_tile(runner.view, index);
    spp = runner.view.strata.spp;
    result.trials.push_back(measure_trial(runner, samples, evaluator, reference, lights));
  }
  return result;
}

void finish(MethodFigure& figure, double pixels, double reference) {
  const double covered = std::max<double>(1, static_cast<double>(figure.covered_pixels));
  const double lights = static_cast<double>(figure.errors.size());
  for (double& error : figure.errors) error /= covered;
  for (const double error : figure.errors) figure.error += error / lights;
  double squares = 0;
  for (const double error : figure.errors)
    squares += (error - figure.error) * (error - figure.error);
  figure.error_stddev = lights > 1 ? std::sqrt(squares / (lights - 1)) : 0;
  figure.error_image = figure.error * covered / std::max(1.0, pixels);
  figure.reference_mean = reference / (3 * lights * covered);
  figure.predicted_error /= covered;
  figure.average_records /= covered;
}

}  // namespace

std::vector<MethodFigure> study_methods(const Scene& scene, const Tracer& tracer,
                                        const MethodStudyParams& params,
                                        const ProgressCallback& callback) {
  CHECK_MSG(params.lights >= 1 && params.tile_stride >= 1 && !params.trials.empty(),
            "lights {} stride {}", params.lights, params.tile_stride);
  const int width = params.width > 0 ? params.width : scene.width;
  const int height = params.height > 0 ? params.height : scene.height;
  std::vector<Runner> runners;
  for (const MethodTrial& trial : params.trials) {
    runners.push_back(make_runner(scene, tracer, params, trial, width, height, callback));
  }
  const ViewSampler reference_view =
      make_view_sampler(scene, tracer, width, height, params.reference_spp,
                        params.is_independent ? params.seed + reference_seed_offset : params.seed);
  const ViewSampler& view = reference_view;
  std::vector<Light> test_lights;
  for (int i = 0; i < params.lights; ++i) {
    test_lights.push_back(interpolate_light(scene.representative_low, scene.representative_high,
                                            params.seed, static_cast<uint64_t>(i)));
  }
  const TrainingSet test = make_training_set(test_lights, view.types.types, view.rays.eye(),
                                             runners.front().params.scene_radius);
  std::vector<int> tiles;
  Random random(params.seed, RandomStream::planning, ~uint64_t{0});
  for (int i = static_cast<int>(random.below(static_cast<uint32_t>(params.tile_stride)));
       i < tile_count(view); i += params.tile_stride) {
    tiles.push_back(i);
  }
  std::vector<MethodFigure> figures(runners.size());
  for (size_t r = 0; r < runners.size(); ++r) {
    figures[r].trial = runners[r].trial;
    figures[r].errors.assign(params.lights, 0.0);
  }
  double pixels = 0;
  double reference = 0;
  Progress progress(callback, "study " + scene.name);
  std::vector<TileResult> batch;
  for (size_t first = 0; first < tiles.size(); first += batch_tiles) {
    batch.assign(std::min(batch_tiles, tiles.size() - first), {});
    parallel_for(batch.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        batch[i] =
            measure_tile(runners, reference_view, tiles[first + i], test.evaluator, params.lights);
      }
    });
    for (const TileResult& tile : batch) {
      pixels += static_cast<double>(tile.pixels);
      reference += tile.reference;
      for (size_t r = 0; r < runners.size(); ++r) {
        MethodFigure& figure = figures[r];
        const TileSums& sums = tile.trials[r];
        for (size_t j = 0; j < sums.errors.size(); ++j) figure.errors[j] += sums.errors[j];
        figure.predicted_error += sums.predicted;
        figure.average_records += static_cast<double>(sums.records);
        figure.thread_ms_reduce += sums.reduce_ms;
        figure.covered_pixels += tile.covered;
      }
    }
    progress.update(static_cast<double>(first + batch.size()), static_cast<double>(tiles.size()));
  }
  for (MethodFigure& figure : figures) finish(figure, pixels, reference);
  return figures;
}

}  // namespace relume

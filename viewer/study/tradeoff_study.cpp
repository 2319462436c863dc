#include "viewer/study/tradeoff_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/image/metrics.h"
#include "core/relight/relight.h"
#include "viewer/study/shadow_truth.h"
#include "viewer/study/significance.h"
#include "viewer/study/tile_values.h"

namespace relume {
namespace {

/// Added to the seed of the truth and of traced pictures, whose samples are others than those that
/// records are made from.
constexpr uint64_t truth_seed_offset = 0x7275746800000000u;
constexpr uint64_t traced_seed_offset = 0x7472616300000000u;

/// Moves are not repeated once all of a picture took so long, in milliseconds.
constexpr double enough_ms = 600;

/// What all settings on a scene share.
struct Setting {
  const Scene& scene;
  const Tracer& tracer;
  const TradeoffParams& params;
  int width;
  int height;
  std::vector<Light> lights;
};

Setting make_setting(const Scene& scene, const Tracer& tracer, const TradeoffParams& params) {
  CHECK_MSG(params.lights >= 2, "lights {}", params.lights);
  Setting setting{scene,
                  tracer,
                  params,
                  params.width > 0 ? params.width : scene.width,
                  params.height > 0 ? params.height : scene.height,
                  {}};
  for (int i = 0; i < params.lights; ++i) {
    setting.lights.push_back(interpolate_light(scene.representative_low, scene.representative_high,
                                               params.seed, static_cast<uint64_t>(i)));
  }
  return setting;
}

std::string name_cache(const TradeoffTrial& trial) {
  return fmt::format("{} {} {} {}", label_of(reduction_method_labels, trial.method), trial.records,
                     trial.budget.average_records, label_of(cache_format_labels, trial.format));
}

std::string name_trial(const Setting& setting, const TradeoffTrial& trial) {
  return fmt::format("{}: {} {} {}", setting.scene.name, name_cache(trial),
                     label_of(shadow_method_labels, trial.shadow),
                     trial.pixels == PixelShare::all ? "all" : "quarter");
}

std::string name_traced(const Setting& setting, int spp) {
  return fmt::format("{}: traced {}", setting.scene.name, spp);
}

/// The truth, made when the first figure needs it.
class Truth {
 public:
  Truth(const Setting& setting, TrialLog& log, ProgressCallback progress)
      : setting_(setting), log_(log), progress_(std::move(progress)) {}

  /// Image i is what light i should give.
  const ShadowTruth& get() {
    if (truth_) return *truth_;
    std::vector<StudyLight> places;
    for (const Light& light : setting_.lights) places.push_back({light.name, {light}});
    const ViewSampler view =
        make_view_sampler(setting_.scene, setting_.tracer, setting_.width, setting_.height,
                          setting_.params.truth_spp, setting_.params.seed + truth_seed_offset);
    truth_ = trace_truth(view, {0, 0, setting_.width, setting_.height}, places, log_, progress_);
    return *truth_;
  }

 private:
  const Setting& setting_;
  TrialLog& log_;
  ProgressCallback progress_;
  std::optional<ShadowTruth> truth_;
};

/// A way to show one light.
class Picture {
 public:
  virtual ~Picture() = default;
  /// The picture under `light` alone, after another light was shown.
  virtual const Image& show(const Light& light) = 0;
};

class RecordPicture final : public Picture {
 public:
  RecordPicture(const Setting& setting, const RelightCache& cache, const TradeoffTrial& trial)
      : state_(make_relight_state(cache)) {
    params_.pixels = trial.pixels;
    if (trial.shadow != ShadowMethod::none) {
      shadow_ = make_shadow(trial.shadow, setting.tracer, cache);
    }
  }
  const Image& show(const Light& light) override {
    relight(state_, {&light, 1}, shadow_.get(), params_);
    return state_.frame;
  }

 private:
  RelightState state_;
  RelightParams params_;
  std::unique_ptr<VisibilitySource> shadow_;
};

/// Every pixel's view rays, hits and shadow rays anew, as a renderer without memory does it.
class TracedPicture final : public Picture {
 public:
  TracedPicture(const Setting& setting, int spp)
      : view_(make_view_sampler(setting.scene, setting.tracer, setting.width, setting.height, spp,
                                setting.params.seed + traced_seed_offset)),
        radius_(std::max(setting.tracer.bounds().radius(), 1e-30f)),
        image_(setting.width, setting.height) {}

  const Image& show(const Light& light) override {
    const TestLights lights = make_test_lights({&light, 1}, view_, radius_);
    parallel_for(static_cast<size_t>(tile_count(view_)), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) trace_tile(static_cast<int>(i), lights);
    });
    return image_;
  }

 private:
  void trace_tile(int index, const TestLights& lights) {
    const SampleTile tile = sample_tile(view_, index);
    const TileValues values = tile_values(tile, view_.types.types, lights, lights.sources());
    for (int y = 0; y < tile.height; ++y) {
      const float* row = &values.traced[static_cast<size_t>(y) * tile.width * 3];
      std::copy_n(row, size_t{3} * tile.width, image_.at(tile.x0, tile.y0 + y));
    }
  }

  ViewSampler view_;
  float radius_;
  Image image_;
};

/// What showing every light once gives: errors, and the least time of each so far.
struct Rounds {
  std::vector<double> errors;
  std::vector<double> least_ms;
  double reference_mean = 0;
  double total_ms = 0;
};

/// Moves from light to light, as many as there are.
void show_lights(const Setting& setting, Truth& truth, Picture& picture, Rounds& rounds) {
  const bool is_first = rounds.errors.empty();
  const auto lights = static_cast<double>(setting.lights.size());
  rounds.least_ms.resize(setting.lights.size(), std::numeric_limits<double>::infinity());
  for (size_t i = 0; i < setting.lights.size(); ++i) {
    const Timer timer;
    const Image& image = picture.show(setting.lights[i]);
    const double ms = timer.ms();
    rounds.least_ms[i] = std::min(rounds.least_ms[i], ms);
    rounds.total_ms += ms;
    if (!is_first) continue;
    const ImageError error = compare_images(image, truth.get().frames[i], truth.get().covered);
    rounds.errors.push_back(error.error_covered);
    rounds.reference_mean += error.reference_mean / lights;
  }
}

/// error, stddev, half interval, reference mean, ms of a light move: as the log keeps them.
std::vector<double> measure_picture(const Setting& setting, Truth& truth, Picture& picture) {
  Rounds rounds;
  for (int round = 0; round < setting.params.repeats; ++round) {
    show_lights(setting, truth, picture, rounds);
    if (rounds.total_ms > enough_ms) break;
  }
  const MeanInterval interval = mean_interval(rounds.errors);
  return {interval.mean, interval.stddev, interval.half_95, rounds.reference_mean,
          mean_interval(rounds.least_ms).mean};
}

/// The records of the last setting asked for.
class CacheShelf {
 public:
  CacheShelf(const Setting& setting, ProgressCallback progress)
      : setting_(setting), progress_(std::move(progress)) {}

  const RelightCache& get(const TradeoffTrial& trial) {
    if (cache_ && name_ == name_cache(trial)) return *cache_;
    cache_.reset();
    const TradeoffParams& study = setting_.params;
    PrepareParams params;
    params.spp = study.spp;
    params.reduction.method = trial.method;
    params.reduction.records = trial.records;
    params.reduction.seed = study.seed;
    params.reduction.stored_members = needs_members() ? max_members : 0;
    params.budget = trial.budget;
    params.training = study.training;
    params.format = trial.format;
    params.width = setting_.width;
    params.height = setting_.height;
    const Timer timer;
    cache_ = prepare_in_memory(setting_.scene, setting_.tracer, params, progress_);
    ms_ = timer.ms();
    name_ = name_cache(trial);
    return *cache_;
  }
  double ms_prepare() const { return ms_; }

 private:
  bool needs_members() const {
    return std::ranges::any_of(setting_.params.trials, [](const TradeoffTrial& trial) {
      return trial.shadow == ShadowMethod::members || trial.shadow == ShadowMethod::coverage;
    });
  }

  const Setting& setting_;
  ProgressCallback progress_;
  std::optional<RelightCache> cache_;
  std::string name_;
  double ms_ = 0;
};

double count_covered(const RelightCache& cache) {
  return static_cast<double>(
      std::ranges::count_if(cache.coverage(), [](float coverage) { return coverage > 0; }));
}

std::vector<double> measure_trial(const Setting& setting, Truth& truth, CacheShelf& shelf,
                                  const TradeoffTrial& trial) {
  const RelightCache& cache = shelf.get(trial);
  RecordPicture picture(setting, cache, trial);
  std::vector<double> values = measure_picture(setting, truth, picture);
  values.push_back(shelf.ms_prepare());
  values.push_back(static_cast<double>(cache.size_bytes()));
  values.push_back(static_cast<double>(cache.info().record_count) /
                   std::max(1.0, count_covered(cache)));
  return values;
}

TradeoffFigure make_figure(const std::vector<double>& values) {
  TradeoffFigure figure;
  CHECK_MSG(values.size() == 5 || values.size() == 8, "{}", values.size());
  figure.error = values[0];
  figure.error_stddev = values[1];
  figure.error_half_95 = values[2];
  figure.reference_mean = values[3];
  figure.ms_light = values[4];
  if (values.size() == 5) return figure;
  figure.ms_prepare = values[5];
  figure.cache_bytes = values[6];
  figure.average_records = values[7];
  return figure;
}

}  // namespace

void mark_pareto(std::vector<TradeoffFigure>& figures) {
  for (TradeoffFigure& figure : figures) {
    figure.is_pareto = std::ranges::none_of(figures, [&](const TradeoffFigure& other) {
      return other.error <= figure.error && other.ms_light <= figure.ms_light &&
             (other.error < figure.error || other.ms_light < figure.ms_light);
    });
  }
}

const TradeoffFigure* recommend(const std::vector<TradeoffFigure>& figures, double limit_ms) {
  const TradeoffFigure* best = nullptr;
  const auto is_better = [limit_ms](const TradeoffFigure& a, const TradeoffFigure& b) {
    const bool a_fits = a.ms_light <= limit_ms;
    if (a_fits != (b.ms_light <= limit_ms)) return a_fits;
    if (a_fits && a.error != b.error) return a.error < b.error;
    return a.ms_light < b.ms_light;
  };
  for (const TradeoffFigure& figure : figures) {
    if (figure.traced_spp > 0) continue;
    if (best == nullptr || is_better(figure, *best)) best = &figure;
  }
  return best;
}

TradeoffStudy study_tradeoff(const Scene& scene, const Tracer& tracer, const TradeoffParams& params,
                             TrialLog& log, const ProgressCallback& callback) {
  CHECK_MSG(!has_emission(scene), "{} emits light", scene.name);
  const Setting setting = make_setting(scene, tracer, params);
  Truth truth(setting, log, callback);
  CacheShelf shelf(setting, callback);
  TradeoffStudy study{setting.width, setting.height, {}};
  Progress progress(callback, "tradeoff " + scene.name);
  const auto total = static_cast<double>(params.trials.size() + params.traced_spp.size());
  const auto add = [&](const std::string& key, const auto& measure) -> TradeoffFigure& {
    const std::vector<double>* known = log.find(key);
    study.figures.push_back(make_figure(known != nullptr ? *known : log.add(key, measure())));
    progress.update(static_cast<double>(study.figures.size()), total);
    return study.figures.back();
  };
  for (const TradeoffTrial& trial : params.trials) {
    add(name_trial(setting, trial), [&] {
      return measure_trial(setting, truth, shelf, trial);
    }).trial = trial;
  }
  for (const int spp : params.traced_spp) {
    add(name_traced(setting, spp), [&] {
      TracedPicture picture(setting, spp);
      return measure_picture(setting, truth, picture);
    }).traced_spp = spp;
  }
  mark_pareto(study.figures);
  return study;
}

}  // namespace relume

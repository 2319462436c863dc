#include "viewer/session/frame_planning.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/shade/shaders.h"
#include "viewer/session/method_training.h"
#include "viewer/session/record_planning.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

/// Every so many tiles one is prepared; of small views more, for a time that can be measured.
constexpr int pilot_stride = 8;
constexpr int least_pilot_tiles = 128;
/// Average records: with fewer a picture is not worth its frame.
constexpr float least_planned_records = 0.5f;
/// Average records that moves are timed with.
constexpr float few_records = 2;
constexpr float many_records = 6;
constexpr int timed_moves = 7;
/// More than the caches of a processor hold.
constexpr size_t evicting_bytes = size_t{192} << 20;
/// Part of the time that is planned with: predictions are about so good.
constexpr double used_part = 0.92;
/// Part of an error that a format may take.
constexpr double format_part = 1.0 / 3;

/// Some tiles of a view under one cost of records, in each format; the others are empty.
struct Pilot {
  std::vector<RelightCache> caches;  ///< parallel to cache_format_labels
  double records = 0;
  double covered = 0;  ///< pixels that samples hit
  double average_records() const { return records / std::max(covered, 1.0); }
};

int choose_pilot_stride(const ViewSampler& view) {
  return std::clamp(tile_count(view) / least_pilot_tiles, 1, pilot_stride);
}

SampleTile make_empty_tile(const ViewSampler& view, int index) {
  const TileRectangle at = tile_rectangle(view, index);
  SampleTile tile;
  tile.x0 = at.x0;
  tile.y0 = at.y0;
  tile.width = at.width;
  tile.height = at.height;
  tile.types.resize(view.types.types.size());
  for (TypedRows& rows : tile.types) rows.first.assign(tile.pixel_count() + 1, 0);
  return tile;
}

Pilot make_pilot(const Scene& scene, const ViewSampler& view, const ReductionParams& reduction,
                 const ReductionLights& lights) {
  const int stride = choose_pilot_stride(view);
  const int tiles = tile_count(view);
  std::vector<SampleTile> reduced(tiles);
  parallel_for(static_cast<size_t>(tiles), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const int index = static_cast<int>(i);
      // Diagonal over the rows, so that no column of the picture is left out.
      const bool is_chosen = (index + index / std::max(1, view.width / tile_size)) % stride == 0;
      const SampleTile samples =
          is_chosen ? sample_tile(view, index) : make_empty_tile(view, index);
      reduced[i] = reduce_tile(samples, view.types.types, reduction, view.width, lights);
    }
  });
  Pilot pilot;
  for (const auto& [format, name] : cache_format_labels) {
    CacheWriter writer;
    pilot.records = pilot.covered = 0;
    for (const SampleTile& tile : reduced) {
      const PackedTileData packed = pack_tile(tile, view.types.types, {format, scene.camera});
      pilot.records += static_cast<double>(packed.record_count);
      pilot.covered += static_cast<double>(packed.coverage.size()) -
                       static_cast<double>(std::ranges::count(packed.coverage, 0));
      writer.add(packed);
    }
    CacheInfo info;
    info.width = view.width;
    info.height = view.height;
    info.camera = scene.camera;
    info.types = view.types.types;
    info.bounds = view.tracer->bounds();
    info.method = label_of(reduction_method_labels, reduction.method);
    info.records = reduction.records;
    info.spp = view.strata.spp;
    info.scene_name = scene.name;
    info.lights = {scene.representative_low, scene.representative_high};
    info.representative_low = scene.representative_low;
    info.representative_high = scene.representative_high;
    writer.finish(info);
    pilot.caches.push_back(
        RelightCache::from_bytes(writer.take_bytes(), shader_table(), scene.name));
  }
  return pilot;
}

/// Mean difference of two frames over the mean of the second, under lights between the scene's
/// representative ones.
double relative_difference(const Scene& scene, const RelightCache& cache,
                           const RelightCache& exact) {
  constexpr int test_lights = 4;
  std::vector<Light> lights;
  for (int i = 0; i < test_lights; ++i) {
    lights.push_back(interpolate_light(scene.representative_low, scene.representative_high,
                                       /*seed=*/1, static_cast<uint64_t>(i)));
  }
  RelightState a = make_relight_state(cache);
  RelightState b = make_relight_state(exact);
  relight(a, lights, nullptr);
  relight(b, lights, nullptr);
  double difference = 0;
  double value = 0;
  for (size_t i = 0; i < a.frame.pixels.size(); ++i) {
    difference += std::abs(double{a.frame.pixels[i]} - b.frame.pixels[i]);
    value += b.frame.pixels[i];
  }
  return value > 0 ? difference / value : 0;
}

double move_ms(const RelightCache& cache, const Tracer& tracer, ShadowMethod method) {
  const auto shadows = method == ShadowMethod::none ? nullptr : make_shadow(method, tracer, cache);
  return measure_move_ms(cache, shadows.get());
}

/// Times of a move over the whole view from those over a part of it.
void forecast_times(const Pilot& few, const Pilot& many, const Pilot& none, double covered,
                    const Tracer& tracer, ShadowMethod shadows, FrameForecast& forecast) {
  for (size_t f = 0; f < forecast.formats.size(); ++f) {
    const double empty_ms = move_ms(none.caches[f], tracer, ShadowMethod::none);
    const auto whole_ms = [&](const Pilot& pilot) {
      const double ms = move_ms(pilot.caches[f], tracer, shadows);
      return empty_ms + std::max(ms - empty_ms, 0.0) * covered / std::max(pilot.covered, 1.0);
    };
    const double few_ms = whole_ms(few);
    const double many_ms = whole_ms(many);
    const double difference = many.average_records() - few.average_records();
    FrameForecast::Format& format = forecast.formats[f];
    format.ms_per_record = difference > 0 ? std::max(0.0, (many_ms - few_ms) / difference) : 0;
    format.fixed_ms = std::max(0.0, few_ms - format.ms_per_record * few.average_records());
  }
}

/// The records that meet `budget`, and what comes of them in a format.
void set_records(const FrameForecast& forecast, const FrameForecast::Format& format,
                 const RecordBudget& budget, FramePlan& plan) {
  plan.format = format.format;
  plan.record_cost = std::max(solve_record_cost(forecast.curves, budget), forecast.least_cost);
  const BudgetOutcome outcome = outcome_at(forecast.curves, plan.record_cost);
  plan.average_records = outcome.average_records;
  plan.error = std::hypot(outcome.error, format.error);
  plan.move_ms = format.fixed_ms + format.ms_per_record * outcome.average_records;
}

FramePlan plan_in_time(const FrameForecast& forecast, const FrameForecast::Format& format,
                       double frame_ms) {
  const double left = used_part * frame_ms - format.fixed_ms;
  FramePlan plan;
  plan.is_met = left >= least_planned_records * format.ms_per_record;
  const double fitting =
      format.ms_per_record > 0 ? left / format.ms_per_record : double{most_planned_records};
  const auto average = static_cast<float>(
      std::clamp(fitting, double{least_planned_records}, double{most_planned_records}));
  set_records(forecast, format, {.average_records = average}, plan);
  return plan;
}

FramePlan plan_in_error(const FrameForecast& forecast, const FrameForecast::Format& format,
                        double target) {
  FramePlan plan;
  const double left = std::max(target * target - format.error * format.error, 0.0);
  // Where the format alone is worse, records cannot help.
  const double of_records = std::max(std::sqrt(left), 0.1 * target);
  set_records(forecast, format, {.target_error = static_cast<float>(of_records)}, plan);
  plan.is_met = plan.error <= target;
  return plan;
}

}  // namespace

double measure_move_ms(const RelightCache& cache, VisibilitySource* shadows) {
  std::vector<char> evicting(evicting_bytes);
  RepeatedFrame frame(cache, static_cast<int>(std::min<size_t>(2, cache.info().lights.size())),
                      InstructionSet::automatic, shadows);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < timed_moves; ++i) {
    // Line by line: filling it whole would go past the caches.
    for (size_t byte = 0; byte < evicting.size(); byte += 64) ++evicting[byte];
    const Timer timer;
    frame.drag_one();
    least = std::min(least, timer.ms());
  }
  return least;
}

FramePlan choose_plan(const FrameForecast& forecast, const FrameGoal& goal) {
  CHECK(goal.is_set());
  std::optional<FramePlan> best;
  for (const FrameForecast::Format& format : forecast.formats) {
    if (goal.format && *goal.format != format.format) continue;
    if (goal.frame_ms > 0) {
      const FramePlan plan = plan_in_time(forecast, format, goal.frame_ms);
      const bool is_better = plan.is_met
                                 ? !best || !best->is_met || plan.error < best->error
                                 : !best || (!best->is_met && plan.move_ms <= best->move_ms);
      if (is_better) best = plan;
    } else {
      const bool is_small_loss = format.error <= format_part * goal.target_error;
      if (!best || is_small_loss) best = plan_in_error(forecast, format, goal.target_error);
    }
  }
  CHECK(best);
  return *best;
}

FrameForecast forecast_frames(const Scene& scene, const ViewSampler& view,
                              const ReductionParams& reduction, const TrainingParams& training,
                              const FrameGoal& goal, const ProgressCallback& progress) {
  CHECK(goal.is_set());
  RecordBudget most;
  if (goal.frame_ms > 0) {
    most.average_records = most_planned_records;
  } else {
    most.target_error = 0.9f * goal.target_error;  // what is left beside a format's third: 0.94
  }
  RecordPlan plan = plan_records(scene, view, reduction, training, most, progress);
  FrameForecast forecast;
  forecast.least_cost = plan.record_cost;
  forecast.curves = std::move(plan.curves);
  ReductionParams params = reduction;
  params.record_cost = plan.record_cost;
  const auto lights = make_method_lights(scene, view, params, training);
  const auto pilot_at = [&](float cost) {
    params.record_cost = std::max(cost, forecast.least_cost);
    return make_pilot(scene, view, params, lights->lights());
  };
  const auto pilot_of = [&](float average) {
    return pilot_at(solve_record_cost(forecast.curves, {.average_records = average}));
  };
  const Pilot many = pilot_of(many_records);
  for (size_t f = 0; f < cache_format_labels.size(); ++f) {
    const CacheFormat format = cache_format_labels[f].value;
    const bool is_exact = format == CacheFormat::exact;
    forecast.formats.push_back(
        {format, is_exact ? 0 : relative_difference(scene, many.caches[f], many.caches[0])});
  }
  if (goal.frame_ms > 0) {
    const double covered = plan.covered_part * view.width * view.height;
    forecast_times(pilot_of(few_records), many, pilot_at(std::numeric_limits<float>::max()),
                   covered, *view.tracer, goal.shadows, forecast);
  }
  return forecast;
}

}  // namespace relume

#include "viewer/session/prepare.h"

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "core/base/timer.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/samples/sample_scene.h"
#include "core/shade/shaders.h"
#include "viewer/session/method_training.h"
#include "viewer/session/record_planning.h"
#include "viewer/session/tile_parts.h"

namespace relume {
namespace {

/// Tiles in flight at a time: enough to feed many threads, few enough to stay small in memory.
constexpr size_t batch_tiles = 128;

/// Tiles that one of several processes makes before it looks what is left to do.
constexpr size_t part_tiles = 64;

/// Where the batches spend their time, summed over threads.
struct StageClock {
  std::atomic<int64_t> sample_us{0};
  std::atomic<int64_t> reduce_us{0};
  std::atomic<int64_t> pack_us{0};
  std::atomic<uint64_t> samples{0};
};

PackedTileData prepare_tile(const ViewSampler& view, const ReductionParams& reduction,
                            const ReductionLights& lights, const PrepareParams& params,
                            CacheFormat format, int index, StageClock& clock) {
  const Timer timer;
  const SampleTile samples =
      params.source ? params.source->tile(view, index) : sample_tile(view, index);
  const double sampled_ms = timer.ms();
  const SampleTile records = reduce_tile(samples, view.types.types, reduction, view.width, lights);
  const double reduced_ms = timer.ms();
  PackedTileData packed = pack_tile(records, view.types.types, {format, view.scene->camera});
  const double packed_ms = timer.ms();
  if (params.on_tile) params.on_tile(view, records);
  clock.sample_us += static_cast<int64_t>(sampled_ms * 1e3);
  clock.reduce_us += static_cast<int64_t>((reduced_ms - sampled_ms) * 1e3);
  clock.pack_us += static_cast<int64_t>((packed_ms - reduced_ms) * 1e3);
  clock.samples += samples.row_count();
  return packed;
}

CacheInfo make_info(const Scene& scene, const ViewSampler& view, const PrepareParams& params,
                    const Bounds& bounds) {
  CacheInfo info;
  info.width = view.width;
  info.height = view.height;
  info.camera = scene.camera;
  info.types = view.types.types;
  info.bounds = bounds;
  info.method = label_of(reduction_method_labels, params.reduction.method);
  info.spp = view.strata.spp;
  info.records =
      params.reduction.method == ReductionMethod::all ? info.spp : params.reduction.records;
  info.average_records = params.budget.average_records;
  info.target_error = params.budget.target_error;
  info.seed = params.reduction.seed;
  info.scene_name = scene.name;
  info.scene_file = scene.file.string();
  info.scene_text = scene.text;
  info.lights = scene.lights;
  info.representative_low = scene.representative_low;
  info.representative_high = scene.representative_high;
  info.exposure = scene.exposure;
  return info;
}

/// Of all that can be seen or cast shadows, world.
Bounds bounds_of(const Tracer& tracer, const PrepareParams& params) {
  Bounds bounds = tracer.bounds();
  if (params.source != nullptr) bounds.extend(params.source->bounds);
  return bounds;
}

/// Not set where records and format are given.
FrameGoal goal_of(const PrepareParams& params) {
  FrameGoal goal;
  goal.frame_ms = params.frame_ms;
  goal.shadows = params.frame_shadows;
  goal.format = params.format;
  if (!params.format) goal.target_error = params.budget.target_error;
  return goal;
}

ReductionParams reduction_in(const Tracer& tracer, const PrepareParams& params) {
  ReductionParams reduction = params.reduction;
  reduction.scene_radius = std::max(bounds_of(tracer, params).radius(), 1e-30f);
  return reduction;
}

ViewSampler view_of(const Scene& scene, const Tracer& tracer, const PrepareParams& params) {
  const bool pure = params.reduction.method == ReductionMethod::pure;
  return make_view_sampler(scene, tracer, params.width > 0 ? params.width : scene.width,
                           params.height > 0 ? params.height : scene.height,
                           pure ? params.reduction.records : params.spp, params.reduction.seed);
}

/// All that making a cache's tiles takes, decided.
struct Plan {
  ViewSampler view;
  ReductionParams reduction;
  CacheInfo info;
  CacheFormat format = CacheFormat::exact;
  std::unique_ptr<const MethodLights> lights;

  size_t tiles() const { return static_cast<size_t>(tile_count(view)); }
};

Plan make_plan(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
               const ProgressCallback& callback, PrepareStats& stats) {
  Plan plan{view_of(scene, tracer, params), reduction_in(tracer, params), {}, {}, nullptr};
  plan.info = make_info(scene, plan.view, params, bounds_of(tracer, params));
  plan.format = params.format.value_or(CacheFormat::exact);
  ReductionParams& reduction = plan.reduction;
  if (const FrameGoal goal = goal_of(params); goal.is_set()) {
    const FramePlan frames = choose_plan(
        forecast_frames(scene, plan.view, reduction, params.training, goal, callback), goal);
    reduction.record_cost = frames.record_cost;
    plan.format = frames.format;
    if (goal.frame_ms > 0) plan.info.average_records = static_cast<float>(frames.average_records);
    stats.plan = frames;
  } else if (params.record_cost > 0) {
    reduction.record_cost = params.record_cost;
  } else if (params.budget.is_set()) {
    reduction.record_cost =
        plan_records(scene, plan.view, reduction, params.training, params.budget, callback)
            .record_cost;
  }
  plan.lights = make_method_lights(scene, plan.view, reduction, params.training);
  return plan;
}

/// Tiles [first, first + count).
TilePart make_part(const Plan& plan, const PrepareParams& params, size_t first, size_t count) {
  StageClock clock;
  TilePart part;
  part.tiles.resize(count);
  parallel_for(count, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      part.tiles[i] = prepare_tile(plan.view, plan.reduction, plan.lights->lights(), params,
                                   plan.format, static_cast<int>(first + i), clock);
    }
  });
  part.samples = clock.samples;
  part.sample_ms = static_cast<double>(clock.sample_us) * 1e-3;
  part.reduce_ms = static_cast<double>(clock.reduce_us) * 1e-3;
  part.pack_ms = static_cast<double>(clock.pack_us) * 1e-3;
  return part;
}

void write_part(const TilePart& part, CacheWriter& writer, PrepareStats& stats) {
  for (const PackedTileData& tile : part.tiles) {
    writer.add(tile);
    stats.records += tile.record_count;
  }
  stats.samples += part.samples;
  stats.sample_ms += part.sample_ms;
  stats.reduce_ms += part.reduce_ms;
  stats.pack_ms += part.pack_ms;
}

void finish_cache(Plan& plan, CacheWriter& writer, const PrepareStats& stats) {
  plan.info.sample_count = stats.samples;
  writer.finish(plan.info);
}

PrepareStats prepare(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                     CacheWriter& writer, const ProgressCallback& callback) {
  PrepareStats stats;
  Plan plan = make_plan(scene, tracer, params, callback, stats);
  Progress progress(callback, "prepare " + scene.name);
  for (size_t first = 0; first < plan.tiles(); first += batch_tiles) {
    const size_t count = std::min(batch_tiles, plan.tiles() - first);
    write_part(make_part(plan, params, first, count), writer, stats);
    progress.update(static_cast<double>(first + count), static_cast<double>(plan.tiles()));
  }
  finish_cache(plan, writer, stats);
  return stats;
}

}  // namespace

FrameForecast forecast_scene(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                             const ProgressCallback& progress) {
  constexpr float any_ms = 1;
  const ViewSampler view = view_of(scene, tracer, params);
  return forecast_frames(scene, view, reduction_in(tracer, params), params.training,
                         {.frame_ms = any_ms}, progress);
}

RelightCache prepare_in_memory(const Scene& scene, const Tracer& tracer,
                               const PrepareParams& params, const ProgressCallback& progress,
                               PrepareStats* stats) {
  CacheWriter writer;
  const PrepareStats taken = prepare(scene, tracer, params, writer, progress);
  if (stats != nullptr) *stats = taken;
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), scene.name);
}

void prepare_to_file(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                     const std::filesystem::path& path, const ProgressCallback& progress,
                     PrepareStats* stats) {
  CacheWriter writer(path);
  const PrepareStats taken = prepare(scene, tracer, params, writer, progress);
  if (stats != nullptr) *stats = taken;
}

void prepare_together(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                      const std::filesystem::path& path, SharedWork& work,
                      const ProgressCallback& progress, PrepareStats* stats) {
  CHECK(params.frame_ms == 0 && !params.on_tile);
  PrepareStats taken;
  Plan plan = make_plan(scene, tracer, params, progress, taken);
  const size_t parts = (plan.tiles() + part_tiles - 1) / part_tiles;
  const auto make = [&](size_t part) {
    const size_t first = part * part_tiles;
    return to_bytes(make_part(plan, params, first, std::min(part_tiles, plan.tiles() - first)));
  };
  const int stage = work.complete("prepare " + scene.name, parts, make, progress);
  work.finish([&] {
    CacheWriter writer(path);
    for (size_t part = 0; part < parts; ++part) {
      write_part(read_tile_part(work.result(stage, part), path.string()), writer, taken);
    }
    finish_cache(plan, writer, taken);
  });
  if (stats != nullptr) *stats = taken;
}

}  // namespace relume

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/relight/relight.h"
#include "viewer/commands/bench_caches.h"
#include "viewer/commands/bench_edits.h"
#include "viewer/commands/bench_frames.h"
#include "viewer/commands/bench_linearity.h"
#include "viewer/commands/bench_machine.h"
#include "viewer/commands/bench_savings.h"
#include "viewer/commands/bench_stages.h"
#include "viewer/commands/bench_time.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/relight_input.h"

namespace relume {
namespace {

void append(std::vector<FigureRow> more, std::vector<FigureRow>& rows) {
  rows.insert(rows.end(), std::make_move_iterator(more.begin()),
              std::make_move_iterator(more.end()));
}

FigureRow bench_row(const std::string& name, double ms, double floor_ms, const CacheInfo& info,
                    double bytes) {
  const auto records = static_cast<double>(info.record_count);
  return {{"name", name},
          {"ms", ms},
          {"floor_ms", floor_ms},
          {"ratio", ms / floor_ms},
          {"records_per_s", records / (ms * 1e-3)},
          {"bytes_per_record", bytes / records}};
}

/// What a light's gain and its traced shadows cost.
void bench_session(const RelightInput& input, int repeats, double floor_ms,
                   std::vector<FigureRow>& rows) {
  const RelightCache& cache = *input.cache;
  const CacheInfo& info = cache.info();
  const auto bytes = static_cast<double>(cache.shading_bytes());
  const auto shadows = make_shadow(ShadowMethod::ray, *input.tracer, cache);
  RelightState state = make_relight_state(cache);
  relight(state, info.lights, shadows.get());
  std::vector<Light> lights = info.lights;
  const double gain_ms = least_ms(repeats, [&] {
    lights.front().gain *= 1.01f;
    relight(state, lights, shadows.get());
  });
  rows.push_back(bench_row("gain", gain_ms, floor_ms, info, bytes));
  const double ray_ms = least_ms(1, [&] {
    lights.front().position.x += 1e-3f * info.bounds.radius();
    lights.front().direction.x += 1e-3f;
    relight(state, lights, shadows.get());
  });
  rows.push_back(bench_row("move-shadow-ray", ray_ms, floor_ms, info, bytes));
}

BenchStagesParams stages_params(const BenchOptions& options, const CacheInfo& info,
                                const CommonOptions& common) {
  const PrepareParams prepare = make_prepare_params(options.prepare, common);
  return {.spp = is_cache_path(options.inputs[0]) ? info.spp : prepare.spp,
          .reduction = prepare.reduction,
          .training = prepare.training,
          .repeats = options.repeats};
}

void require_something_to_time(const RelightCache& cache, const std::string& name) {
  if (cache.info().lights.empty() || cache.info().record_count == 0) {
    throw Error(ErrorKind::usage, name + " has no light or no geometry in view: nothing to time");
  }
}

void bench_one(const BenchOptions& options, const CommonOptions& common,
               std::vector<FigureRow>& rows) {
  const RelightInput input =
      open_input(options.inputs[0], options.prepare, !options.frames_only, common);
  const RelightCache& cache = *input.cache;
  const CacheInfo& info = cache.info();
  require_something_to_time(cache, options.inputs[0]);
  const PortCycles ports = options.port_cycles ? PortCycles(*options.port_cycles) : PortCycles();
  if (!options.frames_only) {
    append(bench_stages(*input.scene, *input.tracer, info, stages_params(options, info, common)),
           rows);
  }
  const MemoryFloor memory = measure_memory_floor(cache, options.repeats + 1);
  rows.push_back(bench_row("read-cache", memory.read_ms, memory.read_ms, info,
                           static_cast<double>(cache.size_bytes())));
  append(bench_frames(cache, options.repeats, memory, ports, thread_count()), rows);
  rows.push_back(memory_row({"cache", &cache}));
  append(bench_edits(cache, options.repeats), rows);
  append(bench_savings(cache, options.repeats), rows);
  append(bench_linearity(cache, options.repeats), rows);
  if (!options.frames_only) bench_session(input, options.repeats, memory.read_ms, rows);
}

/// Every cache against the first.
void bench_many(const BenchOptions& options, const CommonOptions& common,
                std::vector<FigureRow>& rows) {
  std::vector<RelightInput> inputs;
  std::vector<NamedCache> caches;
  for (const std::string& path : options.inputs) {
    inputs.push_back(open_input(path, options.prepare, false, common));
    require_something_to_time(*inputs.back().cache, path);
  }
  for (size_t i = 0; i < inputs.size(); ++i) {
    caches.push_back({std::filesystem::path(options.inputs[i]).stem(), &*inputs[i].cache});
  }
  append(bench_caches(caches, options.repeats), rows);
  for (const NamedCache& cache : caches) rows.push_back(memory_row(cache));
}

/// Pictures of other sizes against one of 1280 x 720, prepared here.
void bench_sizes(const BenchOptions& options, const CommonOptions& common,
                 std::vector<FigureRow>& rows) {
  PrepareOptions prepare = options.prepare;
  if (!prepare.budget.is_set()) prepare.budget.average_records = 3;
  std::vector<PictureSize> sizes{{1280, 720}};
  sizes.insert(sizes.end(), options.sizes.begin(), options.sizes.end());
  const RelightInput input = open_scene(options.inputs[0], common);
  std::vector<RelightCache> pictures;
  std::vector<NamedCache> caches;
  for (const PictureSize& size : sizes) {
    prepare.width = size.width;
    prepare.height = size.height;
    pictures.push_back(prepare_in_memory(*input.scene, *input.tracer,
                                         make_prepare_params(prepare, common),
                                         make_terminal_progress(common.quiet)));
    require_something_to_time(pictures.back(), options.inputs[0]);
  }
  for (size_t i = 0; i < sizes.size(); ++i) {
    caches.push_back({fmt::format("{}x{}", sizes[i].width, sizes[i].height), &pictures[i]});
  }
  append(bench_caches(caches, options.repeats), rows);
  for (const NamedCache& cache : caches) rows.push_back(memory_row(cache));
}

}  // namespace

int run_bench(const BenchOptions& options, const CommonOptions& common) {
  std::vector<FigureRow> rows;
  if (!options.sizes.empty()) {
    bench_sizes(options, common, rows);
  } else if (options.inputs.size() > 1) {
    bench_many(options, common, rows);
  } else {
    bench_one(options, common, rows);
  }
  print_figures("relume-bench-1", common, rows);
  return 0;
}

}  // namespace relume

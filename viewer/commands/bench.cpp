#include <fmt/format.h>

#include "core/base/parallel.h"
#include "core/relight/relight.h"
#include "viewer/commands/bench_frames.h"
#include "viewer/commands/bench_machine.h"
#include "viewer/commands/bench_stages.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/relight_input.h"

namespace relume {
namespace {

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
  const auto bytes = static_cast<double>(cache.size_bytes());
  const auto shadows = make_shadow(ShadowMethod::ray, *input.tracer);
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
  return {.spp = is_cache_path(options.scene) ? info.spp : prepare.spp,
          .reduction = prepare.reduction,
          .training = prepare.training,
          .repeats = options.repeats};
}

}  // namespace

int run_bench(const BenchOptions& options, const CommonOptions& common) {
  const RelightInput input =
      open_input(options.scene, options.prepare, !options.frames_only, common);
  const RelightCache& cache = *input.cache;
  const CacheInfo& info = cache.info();
  const auto bytes = static_cast<double>(cache.size_bytes());
  if (info.lights.empty() || info.record_count == 0) {
    fmt::print(stderr, "{} has no light or no geometry in view: nothing to time\n", options.scene);
    return 2;
  }
  const PortCycles ports = options.port_cycles ? PortCycles(*options.port_cycles) : PortCycles();
  std::vector<FigureRow> rows;
  if (!options.frames_only) {
    rows = bench_stages(*input.scene, *input.tracer, info, stages_params(options, info, common));
  }
  const double floor_ms = read_cache_ms(cache, options.repeats + 1);
  rows.push_back(bench_row("read-cache", floor_ms, floor_ms, info, bytes));
  const auto frames = bench_frames(cache, options.repeats, floor_ms, ports, thread_count());
  rows.insert(rows.end(), frames.begin(), frames.end());
  if (!options.frames_only) bench_session(input, options.repeats, floor_ms, rows);
  print_figures("relume-bench-1", common, rows);
  return 0;
}

}  // namespace relume

#include <fmt/format.h>

#include "core/base/parallel.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "viewer/commands/bench_stages.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/relight_input.h"

namespace relume {
namespace {

/// Sums every float of the cache's tiles with all threads: what memory alone would cost.
double read_cache_ms(const RelightCache& cache, int repeats) {
  std::atomic<uint64_t> sink{0};
  return least_ms(repeats, [&] {
    parallel_for(cache.tiles().size(), 8, [&](size_t begin, size_t end) {
      const auto* first = reinterpret_cast<const uint64_t*>(cache.tiles()[begin].data);
      const auto* last = reinterpret_cast<const uint64_t*>(cache.tiles()[end - 1].coverage);
      uint64_t sum = 0;
      for (const uint64_t* p = first; p + 8 <= last; p += 8) {
        sum += (p[0] ^ p[1]) + (p[2] ^ p[3]) + (p[4] ^ p[5]) + (p[6] ^ p[7]);
      }
      sink += sum;
    });
  });
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

/// One unshadowed light moved, on every instruction set that this machine has.
void bench_frames(const RelightCache& cache, const Light& light, int repeats, double floor_ms,
                  std::vector<FigureRow>& rows) {
  const auto bytes = static_cast<double>(cache.size_bytes());
  for (const auto& [set, name] : instruction_set_labels) {
    if (set == InstructionSet::automatic || !is_supported(set)) continue;
    RelightState state = make_relight_state(cache);
    const std::vector<Light> lights{light};
    const double ms = least_ms(repeats, [&] {
      invalidate(state);
      relight(state, lights, nullptr, {.instruction_set = set});
    });
    rows.push_back(bench_row(fmt::format("frame-{}", name), ms, floor_ms, cache.info(), bytes));
  }
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
  const RelightInput input = open_input(options.scene, options.prepare, true, common);
  const RelightCache& cache = *input.cache;
  const CacheInfo& info = cache.info();
  const auto bytes = static_cast<double>(cache.size_bytes());
  if (info.lights.empty() || info.record_count == 0) {
    fmt::print(stderr, "{} has no light or no geometry in view: nothing to time\n", options.scene);
    return 2;
  }
  std::vector<FigureRow> rows =
      bench_stages(*input.scene, *input.tracer, info, stages_params(options, info, common));
  const double floor_ms = read_cache_ms(cache, options.repeats + 1);
  rows.push_back(bench_row("read-cache", floor_ms, floor_ms, info, bytes));
  bench_frames(cache, info.lights.front(), options.repeats, floor_ms, rows);
  const double reference_ms =
      least_ms(1, [&] { reference_layer(cache, info.lights.front(), nullptr); });
  rows.push_back(bench_row("frame-double-1-thread", reference_ms, floor_ms, info, bytes));

  const auto shadows = make_shadow(ShadowMethod::ray, *input.tracer);
  RelightState state = make_relight_state(cache);
  relight(state, info.lights, shadows.get());
  std::vector<Light> lights = info.lights;
  const double gain_ms = least_ms(options.repeats, [&] {
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
  print_figures("relume-bench-1", common, rows);
  return 0;
}

}  // namespace relume

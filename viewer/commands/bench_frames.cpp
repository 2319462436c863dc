#include "viewer/commands/bench_frames.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "core/base/parallel.h"
#include "core/relight/reference_relight.h"
#include "core/relight/tile_shader.h"
#include "viewer/commands/bench_time.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

/// Bytes that stay in a core's second-level cache beside what else is there.
constexpr size_t hot_bytes = 384 << 10;

/// What all rows share.
struct FrameBench {
  const RelightCache& cache;
  int repeats;
  int threads;
  const MemoryFloor& memory;
  double clock_hz;
  const PortCycles& ports;
};

double frame_ms(const FrameBench& bench, int lights, InstructionSet set) {
  RepeatedFrame frame(bench.cache, lights, set);
  return least_ms(bench.repeats, [&] { frame.move_all(); });
}

uint64_t count_slots(const RelightCache& cache, const PackedTile& tile) {
  uint64_t slots = 0;
  for (int b = 0; b < tile.block_count; ++b) {
    for (size_t t = 0; t < cache.info().types.size(); ++t) slots += cache.block(tile, b).slots[t];
  }
  return slots;
}

/// Tiles from the middle of the picture on, at least one and at most hot_bytes of them.
std::vector<PackedTile> choose_hot_tiles(const RelightCache& cache) {
  std::vector<PackedTile> tiles;
  size_t bytes = 0;
  for (size_t i = 0; i < cache.tiles().size(); ++i) {
    const PackedTile& tile = cache.tiles()[(cache.tiles().size() / 2 + i) % cache.tiles().size()];
    if (tile.block_count == 0) continue;
    bytes += tile.coverage - reinterpret_cast<const uint8_t*>(tile.words);
    if (!tiles.empty() && bytes > hot_bytes) break;
    tiles.push_back(tile);
  }
  return tiles;
}

/// The kernels alone, in cache, as if all threads kept that speed for the whole frame.
double hot_ms(const FrameBench& bench, const std::vector<Light>& lights, InstructionSet set) {
  const TileShader shader(bench.cache, set);
  const std::vector<PackedTile> tiles = choose_hot_tiles(bench.cache);
  std::vector<KernelLight> kernel_lights;
  for (const Light& light : lights) {
    kernel_lights.push_back(make_kernel_light(light, bench.cache.info().bounds.radius()));
  }
  const auto scratch = std::make_unique<TileScratch>();
  const double ms = least_ms(10 * bench.repeats, [&] {
    for (const PackedTile& tile : tiles) shader.shade(tile, kernel_lights, nullptr, *scratch);
  });
  uint64_t hot_slots = 0;
  uint64_t all_slots = 0;
  for (const PackedTile& tile : tiles) hot_slots += count_slots(bench.cache, tile);
  for (const PackedTile& tile : bench.cache.tiles()) all_slots += count_slots(bench.cache, tile);
  return ms * static_cast<double>(all_slots) / static_cast<double>(hot_slots) / bench.threads;
}

double port_ms(const FrameBench& bench, std::string_view set_name,
               const std::vector<Light>& lights) {
  const auto kind = make_kernel_light(lights.front(), bench.cache.info().bounds.radius()).kind;
  return bench.ports.frame_cycles(bench.cache, std::string(set_name), static_cast<int>(kind),
                                  static_cast<int>(lights.size())) /
         bench.clock_hz / bench.threads * 1e3;
}

FigureRow frame_row(const FrameBench& bench, const std::string& name, std::string_view set_name,
                    InstructionSet set, const std::vector<Light>& lights, double double_ms) {
  const auto count = static_cast<int>(lights.size());
  const double ms = frame_ms(bench, count, set);
  set_thread_count(1);
  const double one_thread_ms = frame_ms(bench, count, set);
  set_thread_count(bench.threads);
  const double ports = port_ms(bench, set_name, lights);
  const double floor_ms = std::fmax(bench.memory.read_ms, ports);  // NaN loses
  const double write_ms = bench.memory.read_write_ms.at(count);
  const double hot = hot_ms(bench, lights, set);
  const auto records = static_cast<double>(bench.cache.info().record_count * lights.size());
  return {{"name", name},
          {"ms", ms},
          {"records_per_s", records / (ms * 1e-3)},
          {"memory_floor_ms", bench.memory.read_ms},
          {"write_floor_ms", write_ms},
          {"port_floor_ms", ports},
          {"floor_ms", floor_ms},
          {"ratio", ms / floor_ms},
          {"ratio_write", ms / std::fmax(write_ms, ports)},
          {"hot_ms", hot},
          {"hot_ratio", ms / hot},
          {"ms_1_thread", one_thread_ms},
          {"scaling", one_thread_ms / ms},
          {"double_ratio", double_ms / one_thread_ms}};
}

}  // namespace

std::vector<FigureRow> bench_frames(const RelightCache& cache, int repeats,
                                    const MemoryFloor& memory, const PortCycles& ports,
                                    int threads) {
  const FrameBench bench{cache, repeats, threads, memory, measure_clock_hz(), ports};
  std::vector<FigureRow> rows{{{"name", "machine"},
                               {"clock_ghz", bench.clock_hz * 1e-9},
                               {"threads", int64_t{threads}},
                               {"port_model", ports.model()}}};
  for (const int count : {1, 4}) {
    const std::string suffix = count > 1 ? fmt::format("-{}-lights", count) : "";
    const std::vector<Light> lights = make_bench_lights(cache.info(), count);
    const double double_ms = least_ms(2, [&] {
      for (const Light& light : lights) reference_layer(cache, light, nullptr);
    });
    rows.push_back({{"name", "frame-double-1-thread" + suffix}, {"ms", double_ms}});
    for (const auto& [set, name] : instruction_set_labels) {
      if (set == InstructionSet::automatic || !is_supported(set)) continue;
      rows.push_back(
          frame_row(bench, fmt::format("frame-{}{}", name, suffix), name, set, lights, double_ms));
    }
  }
  return rows;
}

}  // namespace relume

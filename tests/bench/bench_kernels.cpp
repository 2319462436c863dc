// Times the relight kernels over shaders, cache formats, instruction sets and numbers of lights:
// one tile of 8 records a pixel, which stays in cache. Arguments are Google Benchmark's.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <memory>

#include "core/relight/tile_shader.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

constexpr int records_per_pixel = 8;

struct KernelCase {
  SampleType type;
  CacheFormat format;
  InstructionSet set;
  int lights;
};

/// Every pixel has the same number of records; exponents are a material's.
SampleTile make_full_tile(const SampleType& type) {
  SampleTile tile;
  tile.width = tile_size;
  tile.height = tile_size;
  TypedRows& rows = tile.types.emplace_back();
  rows.first.push_back(0);
  for (uint64_t pixel = 0; pixel < tile_size * tile_size; ++pixel) {
    Random random(1, RandomStream::tests, pixel);
    for (int i = 0; i < records_per_pixel; ++i) {
      append_random_vector(type, random, rows.values);
      if (type.width == 14) rows.values.back() = random.uniform(5, 100);
      rows.weights.push_back(1.0f / records_per_pixel);
    }
    rows.first.push_back(static_cast<uint32_t>(rows.rows()));
  }
  return tile;
}

RelightCache make_cache(const KernelCase& c) {
  const SampleTile tile = make_full_tile(c.type);
  const CacheInfo info = make_tile_info(tile, {c.type}, {0, 0, 5});
  CacheWriter writer;
  writer.add(pack_tile(tile, info.types, {c.format, info.camera}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "bench");
}

void shade_tile(benchmark::State& state, const KernelCase& c) {
  const RelightCache cache = make_cache(c);
  const TileShader shader(cache, c.set);
  std::vector<KernelLight> lights;
  for (int i = 0; i < c.lights; ++i) {
    const auto x = static_cast<float>(i);
    lights.push_back(make_kernel_light(make_point_light({x, 3 - x, 4}), 1));
  }
  const auto scratch = std::make_unique<TileScratch>();
  for (auto step : state) {
    shader.shade(cache.tiles()[0], lights, nullptr, *scratch);
    benchmark::DoNotOptimize(scratch->light_sums(0));
  }
  const auto records = static_cast<double>(cache.info().record_count * lights.size());
  state.counters["records_x_lights"] =
      benchmark::Counter(records, benchmark::Counter::kIsIterationInvariantRate);
}

void register_all() {
  for (const SampleType& type : all_sample_types()) {
    for (const auto& [format, format_name] : cache_format_labels) {
      for (const auto& [set, set_name] : instruction_set_labels) {
        if (set == InstructionSet::automatic || !is_supported(set)) continue;
        for (const int lights : {1, 2, 4}) {
          const std::string name =
              fmt::format("{}/{}/{}/lights:{}", type.name, format_name, set_name, lights);
          benchmark::RegisterBenchmark(name.c_str(), shade_tile,
                                       KernelCase{type, format, set, lights});
        }
      }
    }
  }
}

}  // namespace
}  // namespace relume

int main(int argc, char** argv) {
  relume::register_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

// Times the relight kernels over shaders, cache formats, instruction sets, light kinds and numbers
// of lights: one tile of 8 records a pixel, which stays in cache. Counters: time a record and
// light, and bytes a record. Arguments are Google Benchmark's, for instance
// --benchmark_filter=phong/standard/avx2/point.

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
  LightKernel kind;
  int lights;
};

struct NamedKind {
  LightKernel kind;
  const char* name;
};

constexpr NamedKind light_kinds[] = {{LightKernel::point, "point"},
                                     {LightKernel::point_constant, "point-constant"},
                                     {LightKernel::point_range, "point-range"},
                                     {LightKernel::spot, "spot"},
                                     {LightKernel::spot_constant, "spot-constant"},
                                     {LightKernel::spot_range, "spot-range"},
                                     {LightKernel::directional, "directional"}};
static_assert(std::size(light_kinds) == static_cast<size_t>(LightKernel::count));

/// A light of a kind; several differ in where they are. The cones hold some of the records.
KernelLight make_light(LightKernel kind, int i) {
  const auto x = static_cast<float>(i);
  const vec3 position(x, 3 - x, 4);
  const bool falloff = has_falloff(kind);
  Light light = make_point_light(position, 1, falloff);
  if (is_spot(kind)) {
    light = make_spot_light(position, -position, 5, 10, falloff);
  } else if (kind == LightKernel::directional) {
    light = make_directional_light(-position);
  }
  if (has_range(kind)) light.range = 6;
  return make_kernel_light(light, 1);
}

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
      if (type.width == 15) rows.values.back() = random.uniform(0.2f, 0.8f);
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
  for (int i = 0; i < c.lights; ++i) lights.push_back(make_light(c.kind, i));
  const auto scratch = std::make_unique<TileScratch>();
  for (auto step : state) {
    shader.shade(cache.tiles()[0], lights, nullptr, *scratch);
    benchmark::DoNotOptimize(scratch->light_sums(0));
  }
  using benchmark::Counter;
  const auto records = static_cast<double>(cache.info().record_count);
  state.counters["per_record_and_light"] =
      Counter(records * c.lights, Counter::kIsIterationInvariantRate | Counter::kInvert);
  state.counters["bytes_per_record"] = 4.0 * cache.layouts()[0].words;
}

void register_all() {
  for (const SampleType& type : all_sample_types()) {
    for (const auto& [format, format_name] : cache_format_labels) {
      for (const auto& [set, set_name] : instruction_set_labels) {
        if (set == InstructionSet::automatic || !is_supported(set)) continue;
        for (const auto& [kind, kind_name] : light_kinds) {
          for (const int lights : {1, 2, 4}) {
            const std::string name = fmt::format("{}/{}/{}/{}/lights:{}", type.name, format_name,
                                                 set_name, kind_name, lights);
            benchmark::RegisterBenchmark(name.c_str(), shade_tile,
                                         KernelCase{type, format, set, kind, lights});
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace relume

int main(int argc, char** argv) {
  relume::register_all();
  // There are many; an argument of the same name comes later and counts.
  char short_time[] = "--benchmark_min_time=0.05";
  std::vector<char*> arguments(argv, argv + argc);
  arguments.insert(arguments.begin() + 1, short_time);
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

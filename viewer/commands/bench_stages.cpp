#include "viewer/commands/bench_stages.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/base/parallel.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/samples/sample_scene.h"
#include "viewer/commands/bench_time.h"
#include "viewer/session/method_training.h"

namespace relume {
namespace {

/// Samples held in memory at a time: some 14 floats each, a quarter gigabyte or two.
constexpr int64_t most_samples = 8'000'000;

/// Repeats of a stage end after this time.
constexpr double enough_ms = 4000;

constexpr int pilot_tiles = 16;

/// `count` of `total` indices, ascending: one from each of `count` equal parts, at places that the
/// golden ratio spreads, so that no column of tiles is preferred.
std::vector<int> spread_indices(int total, int count) {
  std::vector<int> indices;
  for (int i = 0; i < count; ++i) {
    const double place = 0.6180339887498949 * i;
    indices.push_back(static_cast<int>((i + place - std::floor(place)) * total / count));
  }
  return indices;
}

/// The picture whose preprocess is timed.
struct Picture {
  const Scene& scene;
  const CacheInfo& info;
  const BenchStagesParams& params;
  ReductionParams reduction;
  ViewSampler view;
};

/// What a stage took, for what, and what came out of it.
template <class Tile>
struct Stage {
  double ms = 0;
  int64_t pixels = 0;
  uint64_t samples = 0;  ///< of the pixels
  uint64_t records = 0;  ///< out
  std::vector<Tile> tiles;
};

template <class Tile>
FigureRow stage_row(const std::string& name, const Stage<Tile>& stage, const CacheInfo& info) {
  const double pixels = static_cast<double>(info.width) * info.height;
  const double seconds = stage.ms * 1e-3;
  return {{"name", name},
          {"ms", stage.ms * pixels / static_cast<double>(stage.pixels)},
          {"pixels", stage.pixels},
          {"records_per_s", static_cast<double>(stage.records) / seconds},
          {"samples_per_s", static_cast<double>(stage.samples) / seconds}};
}

/// Makes `count` tiles with all threads, `make(i)` each.
template <class Tile, class Make>
void time_tiles(int repeats, size_t count, Stage<Tile>& stage, const Make& make) {
  stage.tiles.resize(count);
  const auto make_all = [&] {
    parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) stage.tiles[i] = make(i);
    });
  };
  stage.ms = least_ms(repeats, make_all, enough_ms);
}

Stage<SampleTile> time_sampling(const Picture& picture) {
  const int total = tile_count(picture.view);
  const int64_t tile_samples = int64_t{tile_size} * tile_size * picture.params.spp;
  const auto count = static_cast<int>(std::clamp<int64_t>(most_samples / tile_samples, 1, total));
  const std::vector<int> indices = spread_indices(total, count);
  Stage<SampleTile> stage;
  time_tiles(picture.params.repeats, indices.size(), stage,
             [&](size_t i) { return sample_tile(picture.view, indices[i]); });
  for (const SampleTile& tile : stage.tiles) {
    stage.pixels += tile.pixel_count();
    stage.samples += tile.row_count();
  }
  stage.records = stage.samples;
  return stage;
}

Stage<SampleTile> time_reduction(const Picture& picture, std::span<const SampleTile> samples,
                                 ReductionMethod method) {
  ReductionParams reduction = picture.reduction;
  reduction.method = method;
  const auto lights =
      make_method_lights(picture.scene, picture.view, reduction, picture.params.training);
  const auto total = static_cast<int>(samples.size());
  Stage<SampleTile> stage;
  const auto run = [&](int repeats, std::span<const int> indices) {
    time_tiles(repeats, indices.size(), stage, [&](size_t i) {
      return reduce_tile(samples[indices[i]], picture.view.types.types, reduction,
                         picture.view.width, lights->lights());
    });
  };
  const int pilot = std::min(pilot_tiles, total);
  run(1, spread_indices(total, pilot));
  const double affordable = picture.params.most_reduce_ms / stage.ms * pilot;
  const auto count = static_cast<int>(std::clamp<double>(affordable, pilot, total));
  const std::vector<int> indices = spread_indices(total, count);
  run(picture.params.repeats, indices);
  for (const int i : indices) {
    stage.pixels += samples[i].pixel_count();
    stage.samples += samples[i].row_count();
  }
  for (const SampleTile& tile : stage.tiles) stage.records += tile.row_count();
  return stage;
}

Stage<PackedTileData> time_packing(const Picture& picture, const Stage<SampleTile>& records) {
  Stage<PackedTileData> stage{0, records.pixels, records.samples, records.records, {}};
  time_tiles(picture.params.repeats, records.tiles.size(), stage,
             [&](size_t i) { return pack_tile(records.tiles[i], picture.view.types.types); });
  return stage;
}

FigureRow bench_writing(const Picture& picture, const Stage<PackedTileData>& packed) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("relume-bench-{}.relume", getpid());
  Stage<std::byte> stage{0, packed.pixels, packed.samples, packed.records, {}};
  const auto write = [&] {
    CacheWriter writer(path);
    for (const PackedTileData& tile : packed.tiles) writer.add(tile);
    writer.finish(picture.info);
  };
  stage.ms = least_ms(picture.params.repeats, write, enough_ms);
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  std::filesystem::remove(path);
  FigureRow row = stage_row("write-cache", stage, picture.info);
  row.push_back({"bytes_per_record", bytes / static_cast<double>(packed.records)});
  return row;
}

}  // namespace

std::vector<FigureRow> bench_stages(const Scene& scene, const Tracer& tracer, const CacheInfo& info,
                                    const BenchStagesParams& params) {
  Picture picture{
      scene, info, params, params.reduction,
      make_view_sampler(scene, tracer, info.width, info.height, params.spp, params.reduction.seed)};
  picture.reduction.scene_radius = std::max(tracer.bounds().radius(), 1e-30f);
  const Stage<SampleTile> samples = time_sampling(picture);
  std::vector<FigureRow> rows{stage_row("sample", samples, info)};
  Stage<SampleTile> records;  // strong k-means'
  for (const ReductionMethod method :
       {ReductionMethod::kmeans, ReductionMethod::strong_kmeans, ReductionMethod::light_fit_fast,
        ReductionMethod::light_fit}) {
    Stage<SampleTile> stage = time_reduction(picture, samples.tiles, method);
    const auto label = label_of(reduction_method_labels, method);
    rows.push_back(stage_row(fmt::format("reduce-{}", label), stage, info));
    if (method == ReductionMethod::strong_kmeans) records = std::move(stage);
  }
  const Stage<PackedTileData> packed = time_packing(picture, records);
  rows.push_back(stage_row("pack", packed, info));
  rows.push_back(bench_writing(picture, packed));
  return rows;
}

}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"
#include "viewer/commands/bench_frames.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

RelightCache make_cache() {
  const std::vector<SampleType> types = all_sample_types();
  const std::vector<SampleTile> tiles = make_random_tiles(types, 64, 48, 3);
  CacheWriter writer;
  for (const SampleTile& tile : tiles) writer.add(pack_tile(tile, types));
  CacheInfo info = make_tile_info(tiles[0], types, {0, 0, 5});
  info.width = 64;
  info.height = 48;
  info.lights = {make_point_light({1, 2, 3}, 20)};
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

double number(const FigureRow& row, const std::string& name) {
  for (const auto& [key, figure] : row) {
    if (key == name) return std::get<double>(figure);
  }
  ADD_FAILURE() << name << " is missing";
  return 0;
}

TEST(PortCycles, SumOverTheSlotsOfEachType) {
  const TemporaryFolder folder;
  const RelightCache cache = make_cache();
  uint64_t slots[5] = {};
  for (const PackedTile& tile : cache.tiles()) {
    for (int b = 0; b < tile.block_count; ++b) {
      for (size_t t = 0; t < 5; ++t) slots[t] += cache.block(tile, b).slots[t];
    }
  }
  const auto path = folder.file("ports");
  std::ofstream(path) << "some model\navx2 lambert exact 0 4 10\navx2 phong exact 0 4 100.5\n"
                         "avx2 kajiya-kay exact 0 4 1000\navx2 leaf exact 0 4 20\navx2 leaf exact "
                         "1 4 77\navx2 leaf compact 0 4 5000\navx2 ggx exact 0 4 7\n";
  const PortCycles ports(path);
  EXPECT_EQ(ports.model(), "some model");
  const auto count = [&](size_t t) { return static_cast<double>(slots[t]); };
  const double expected =
      10.0 * count(0) + 100.5 * count(1) + 1000.0 * count(2) + 20.0 * count(3) + 7.0 * count(4);
  EXPECT_EQ(ports.frame_cycles(cache, "avx2", 0, 4), expected);
  EXPECT_TRUE(std::isnan(ports.frame_cycles(cache, "avx2", 1, 4)));
  EXPECT_TRUE(std::isnan(ports.frame_cycles(cache, "sse4.2", 0, 4)));
  EXPECT_TRUE(std::isnan(PortCycles().frame_cycles(cache, "avx2", 0, 4)));
  EXPECT_EQ(PortCycles().model(), "no llvm-mca");
}

TEST(PortCycles, AnythingElseIsRefused) {
  const TemporaryFolder folder;
  EXPECT_ERROR(PortCycles(folder.file("none")), ErrorKind::input, "none");
  std::ofstream(folder.file("bad")) << "model\navx2 lambert exact zero 4 10\n";
  EXPECT_ERROR(PortCycles(folder.file("bad")), ErrorKind::input, "not a list of kernels");
}

TEST(BenchFrames, RatiosFollowFromTheTimes) {
  const TemporaryFolder folder;
  const auto path = folder.file("ports");
  std::ofstream(path) << "model\nscalar lambert exact 0 1 1e12\nscalar phong exact 0 1 0\n"
                         "scalar kajiya-kay exact 0 1 0\nscalar leaf exact 0 1 0\n"
                         "scalar ggx exact 0 1 0\n";
  const std::vector<FigureRow> rows =
      bench_frames(make_cache(), 2, {1.25, {{1, 2.5}, {4, 5.0}}}, PortCycles(path), 1);
  int frames = 0;
  for (const FigureRow& row : rows) {
    const std::string name = std::get<std::string>(row[0].second);
    if (name == "machine") {
      EXPECT_GT(number(row, "clock_ghz"), 0.2);
    }
    if (name == "machine" || name.starts_with("frame-double")) continue;
    SCOPED_TRACE(name);
    ++frames;
    EXPECT_EQ(number(row, "memory_floor_ms"), 1.25);
    if (name == "frame-scalar") {
      EXPECT_EQ(number(row, "floor_ms"), number(row, "port_floor_ms"));
      EXPECT_GT(number(row, "floor_ms"), 1e3);
    } else {
      EXPECT_TRUE(std::isnan(number(row, "port_floor_ms")));
      EXPECT_EQ(number(row, "floor_ms"), 1.25);
    }
    EXPECT_DOUBLE_EQ(number(row, "ratio"), number(row, "ms") / number(row, "floor_ms"));
    const double write_ms = name.ends_with("-4-lights") ? 5.0 : 2.5;
    EXPECT_EQ(number(row, "write_floor_ms"), write_ms);
    EXPECT_DOUBLE_EQ(number(row, "ratio_write"),
                     number(row, "ms") / std::fmax(write_ms, number(row, "port_floor_ms")));
    EXPECT_DOUBLE_EQ(number(row, "hot_ratio"), number(row, "ms") / number(row, "hot_ms"));
    EXPECT_DOUBLE_EQ(number(row, "scaling"), number(row, "ms_1_thread") / number(row, "ms"));
    EXPECT_GT(number(row, "double_ratio"), 0);
  }
  EXPECT_GE(frames, 2);
}

}  // namespace
}  // namespace relume

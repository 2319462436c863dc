#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "viewer/commands/bench_caches.h"
#include "viewer/commands/bench_cuts.h"
#include "viewer/commands/bench_edits.h"
#include "viewer/commands/bench_linearity.h"
#include "viewer/commands/bench_machine.h"
#include "viewer/commands/bench_savings.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

RelightCache make_cache(CacheFormat format, int width = 48, int height = 72, bool emits = false) {
  const std::vector<SampleType> types = all_sample_types();
  std::vector<SampleTile> tiles = make_random_tiles(types, width, height, 2);
  for (SampleTile& tile : tiles) {
    for (int i = 0; emits && i < tile.pixel_count(); ++i) {
      tile.emission.emplace_back(tile.x0 + 1, tile.y0, i);
    }
  }
  CacheInfo info = make_tile_info(tiles[0], types, {0, 0, 5});
  info.width = width;
  info.height = height;
  info.lights = {make_point_light({1, 2, 3}, 20)};
  CacheWriter writer;
  for (const SampleTile& tile : tiles) writer.add(pack_tile(tile, types, {format, info.camera}));
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
}

const Figure& find(const FigureRow& row, const std::string& name) {
  for (const auto& [key, figure] : row) {
    if (key == name) return figure;
  }
  throw std::out_of_range(name);
}

double number(const FigureRow& row, const std::string& name) {
  return std::get<double>(find(row, name));
}

std::string name_of(const FigureRow& row) {
  return std::get<std::string>(find(row, "name"));
}

std::vector<std::string> names_of(const std::vector<FigureRow>& rows) {
  std::vector<std::string> names;
  for (const FigureRow& row : rows) names.push_back(name_of(row));
  return names;
}

class CacheCut : public testing::TestWithParam<CacheFormat> {
 protected:
  RelightCache cache_ = make_cache(GetParam());
};

TEST_P(CacheCut, GivesEveryCoveredPixelAsManyRecords) {
  for (const int records : {1, 3, 16}) {
    const RelightCache cut = cut_cache(cache_, {records, 0});
    EXPECT_EQ(cut.info().format, GetParam());
    const std::vector<float> before = cache_.record_counts();
    const std::vector<float> after = cut.record_counts();
    for (size_t i = 0; i < before.size(); ++i) {
      ASSERT_EQ(after[i], before[i] > 0 ? static_cast<float>(records) : 0) << records;
    }
  }
}

TEST_P(CacheCut, OfNothingShowsTheSamePicture) {
  const RelightCache cut = cut_cache(cache_, {});
  const Image frame = render_frame(cache_, cache_.info().lights);
  const Image again = render_frame(cut, cache_.info().lights);
  if (GetParam() == CacheFormat::exact) {
    EXPECT_EQ(again.pixels, frame.pixels);
  }
  double sum = 0;
  double difference = 0;
  for (size_t i = 0; i < frame.pixels.size(); ++i) {
    sum += static_cast<double>(frame.pixels[i]);
    difference += std::abs(static_cast<double>(again.pixels[i]) - frame.pixels[i]);
  }
  EXPECT_LE(difference, 0.01 * sum);
}

TEST_P(CacheCut, TakesFullRowsFromAllOverThePicture) {
  const RelightCache cut = cut_cache(cache_, {0, 2});
  EXPECT_EQ(cut.info().height, 32);
  const std::vector<float> before = cache_.record_counts();
  const std::vector<float> after = cut.record_counts();
  for (size_t y = 0; y < 32; ++y) {
    const size_t source = y < 16 ? y + 16 : y + 32;  // rows 1 and 3 of the four full ones
    for (size_t x = 0; x < 48; ++x) ASSERT_EQ(after[y * 48 + x], before[source * 48 + x]);
  }
  EXPECT_EQ(cut_cache(cache_, {0, 99}).info().height, 72);
}

TEST_P(CacheCut, KeepsWhatMaterialsEmit) {
  const RelightCache cache = make_cache(GetParam(), 48, 72, true);
  const std::vector<float> before = cache.emission();
  ASSERT_EQ(before.size(), size_t{3} * 48 * 72);
  EXPECT_EQ(cut_cache(cache, {1, 0}).emission(), before);
  EXPECT_EQ(make_diffuse_cache(cache, DiffuseShader::lambert, 0).emission(), before);
  const std::vector<float> after = cut_cache(cache, {0, 2}).emission();
  const auto row = [](int y) { return std::ptrdiff_t{3} * 48 * y; };
  EXPECT_TRUE(std::equal(after.begin(), after.begin() + row(16), before.begin() + row(16)));
  EXPECT_TRUE(std::equal(after.begin() + row(16), after.end(), before.begin() + row(48)));
  EXPECT_FALSE(cut_cache(cache_, {}).info().has_emission);
}

TEST_P(CacheCut, DiffusePartLooksTheSameInBothShaders) {
  const RelightCache lambert = make_diffuse_cache(cache_, DiffuseShader::lambert, 0);
  const RelightCache phong = make_diffuse_cache(cache_, DiffuseShader::phong, 0);
  EXPECT_LT(lambert.size_bytes(), phong.size_bytes());
  const Image image = render_frame(lambert, cache_.info().lights);
  float brightest = 0;
  for (const float value : image.pixels) brightest = std::max(brightest, value);
  EXPECT_GT(brightest, 0);
  // Compact Phong records have a bit less for directions.
  const float bound = GetParam() == CacheFormat::compact ? 2e-2f : 1e-4f;
  EXPECT_LE(max_difference(image, render_frame(phong, cache_.info().lights)), bound * brightest);
}

INSTANTIATE_TEST_SUITE_P(Formats, CacheCut,
                         testing::Values(CacheFormat::exact, CacheFormat::standard,
                                         CacheFormat::compact),
                         [](const auto& parameter) {
                           return std::string(label_of(cache_format_labels, parameter.param));
                         });

TEST(LineFit, FindsTheLineAndItsLargestDeviation) {
  const LineFit line = fit_line({1, 2, 4, 8}, {5, 7, 11, 19});
  EXPECT_NEAR(line.intercept_ms, 3, 1e-9);
  EXPECT_NEAR(line.slope_ms, 2, 1e-9);
  EXPECT_NEAR(line.largest_deviation, 0, 1e-9);
  const LineFit bent = fit_line({1, 2, 3}, {1, 1.5, 1});
  EXPECT_GT(bent.largest_deviation, 0.2);
  for (const double x : {1.0, 2.0, 3.0}) {
    const double ms = x == 2 ? 1.5 : 1;
    EXPECT_LE(std::abs((bent.intercept_ms + bent.slope_ms * x) / ms - 1),
              bent.largest_deviation + 1e-12);
  }
  EXPECT_TRUE(std::isnan(fit_line({2, 2}, {1, 3}).slope_ms));
}

TEST(BenchEdits, ComparesWithAFrameOfOneLight) {
  const std::vector<FigureRow> rows = bench_edits(make_cache(CacheFormat::exact), 1);
  EXPECT_EQ(names_of(rows),
            (std::vector<std::string>{"coarse-frame", "gain-16-layers", "gain-drag-16-layers",
                                      "drag-of-1", "drag-of-16", "drag-of-64", "drag-of-256",
                                      "first-frame-1", "first-frame-16", "first-frame-64",
                                      "first-frame-256"}));
  for (const FigureRow& row : rows) {
    EXPECT_GT(number(row, "ms"), 0) << name_of(row);
    EXPECT_GT(number(row, "ratio"), 0) << name_of(row);
  }
  EXPECT_GT(std::get<int64_t>(find(rows[6], "state_bytes")),
            std::get<int64_t>(find(rows[3], "state_bytes")));
}

TEST(BenchSavings, SetsEachKernelBesideTheGeneralOne) {
  const std::vector<FigureRow> rows = bench_savings(make_cache(CacheFormat::standard), 1);
  EXPECT_EQ(names_of(rows),
            (std::vector<std::string>{"only-diffuse", "shadows-off", "lights-in-one-pass"}));
  for (const FigureRow& row : rows) {
    EXPECT_DOUBLE_EQ(number(row, "ratio"), number(row, "ms") / number(row, "general_ms"));
  }
}

TEST(BenchLinearity, FitsALinePerGroupAndPredictsWhatItHeldBack) {
  const std::vector<FigureRow> rows = bench_linearity(make_cache(CacheFormat::exact), 1);
  int lines = 0;
  double largest = 0;
  double least_ratio = 1e9;
  double told_least = 0;
  for (const FigureRow& row : rows) {
    const std::string name = name_of(row);
    SCOPED_TRACE(name);
    if (name.starts_with("linear-")) {
      ++lines;
      EXPECT_DOUBLE_EQ(number(row, "largest_deviation"), largest);
      largest = 0;
    } else if (name == "frame-cost") {
      told_least = number(row, "least_predicted_ratio");
    } else if (name.starts_with("frame-cost-")) {
      EXPECT_DOUBLE_EQ(number(row, "predicted_ratio"),
                       number(row, "predicted_ms") / number(row, "ms"));
      least_ratio = std::min(least_ratio, number(row, "predicted_ratio"));
    } else {
      EXPECT_NEAR(number(row, "deviation"), number(row, "fit_ms") / number(row, "ms") - 1, 1e-12);
      largest = std::max(largest, std::abs(number(row, "deviation")));
      if (name.starts_with("records-")) {
        EXPECT_EQ(name, fmt::format("records-{}", number(row, "x")));
      }
    }
  }
  EXPECT_EQ(lines, 3);
  EXPECT_EQ(told_least, least_ratio);
}

TEST(BenchCaches, SetEachBesideTheFirst) {
  const RelightCache small = make_cache(CacheFormat::compact, 32, 32);
  const RelightCache large = make_cache(CacheFormat::exact);
  const NamedCache caches[] = {{"small", &small}, {"large", &large}};
  const std::vector<FigureRow> rows = bench_caches(caches, 2);
  EXPECT_EQ(names_of(rows),
            (std::vector<std::string>{"small", "large", "small-4-lights", "large-4-lights"}));
  for (size_t i = 0; i < rows.size(); ++i) {
    const FigureRow& row = rows[i];
    const FigureRow& first = rows[i / 2 * 2];
    const RelightCache& cache = i % 2 == 0 ? small : large;
    const double lights = i < 2 ? 1 : 4;
    EXPECT_DOUBLE_EQ(number(row, "ratio"), number(row, "ms") / number(first, "ms"));
    EXPECT_DOUBLE_EQ(
        number(row, "ns_per_record"),
        number(row, "ms") * 1e6 / static_cast<double>(cache.info().record_count) / lights);
    EXPECT_EQ(std::get<int64_t>(find(row, "bytes")), static_cast<int64_t>(cache.size_bytes()));
  }
}

TEST(MemoryRow, CountsTheStateBesideTheCache) {
  const RelightCache cache = make_cache(CacheFormat::exact, 640, 160);
  const FigureRow row = memory_row({"it", &cache});
  EXPECT_EQ(name_of(row), "memory-it");
  const auto state = static_cast<double>(std::get<int64_t>(find(row, "state_bytes")));
  const auto bytes = static_cast<double>(cache.size_bytes());
  EXPECT_GE(state, 640 * 160 * 3 * 4) << "a frame at least";
  EXPECT_DOUBLE_EQ(number(row, "working_over_cache"), (bytes + state) / bytes);
}

TEST(MemoryFloor, KnowsWhatReadingAndWritingTake) {
  const MemoryFloor memory = measure_memory_floor(make_cache(CacheFormat::exact), 3);
  EXPECT_GT(memory.read_ms, 0);
  EXPECT_GT(memory.read_write_ms.at(1), 0);
  EXPECT_GT(memory.read_write_ms.at(4), 0);
}

TEST(FigureTable, SetsRowsOfTheSameNamesInColumns) {
  const std::vector<FigureRow> rows = {{{"name", "machine"}, {"threads", int64_t{2}}},
                                       {{"name", "a"}, {"ms", 1.5}},
                                       {{"name", "longer"}, {"ms", 12.25}}};
  EXPECT_EQ(format_table(rows),
            "name               machine\nthreads            2\n\n"
            "name       ms\na         1.5\nlonger  12.25\n");
}

}  // namespace
}  // namespace relume

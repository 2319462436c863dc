#include <gtest/gtest.h>

#include <algorithm>

#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/commands/bench_stages.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

const Figure* find(const FigureRow& row, const std::string& name) {
  const auto found =
      std::find_if(row.begin(), row.end(), [&](const auto& entry) { return entry.first == name; });
  return found == row.end() ? nullptr : &found->second;
}

double number(const FigureRow& row, const std::string& name) {
  const Figure* figure = find(row, name);
  if (figure == nullptr) return -1;
  if (const auto* whole = std::get_if<int64_t>(figure)) return static_cast<double>(*whole);
  return std::get<double>(*figure);
}

/// The stages of the built-in spheres, small: 12 x 8 tiles.
class BenchStages : public testing::Test {
 protected:
  static constexpr int width = 192;
  static constexpr int height = 128;

  std::vector<FigureRow> run(double most_reduce_ms) {
    BenchStagesParams params;
    params.spp = 4;
    params.reduction.records = 2;
    params.repeats = 1;
    params.most_reduce_ms = most_reduce_ms;
    return bench_stages(scene_, tracer_, cache_.info(), params);
  }

  RelightCache prepare() const {
    PrepareParams params;
    params.spp = 4;
    params.reduction.records = 2;
    params.width = width;
    params.height = height;
    return prepare_in_memory(scene_, tracer_, params, {});
  }

  Scene scene_ = load_scene("spheres", shader_table());
  Tracer tracer_{scene_};
  RelightCache cache_ = prepare();
};

TEST_F(BenchStages, CountWhatThePreparationMakes) {
  const std::vector<FigureRow> rows = run(1e9);
  std::vector<std::string> names;
  for (const FigureRow& row : rows) {
    names.push_back(std::get<std::string>(*find(row, "name")));
    SCOPED_TRACE(names.back());
    EXPECT_EQ(number(row, "pixels"), width * height);
    const double seconds = number(row, "ms") * 1e-3;
    ASSERT_GT(seconds, 0);
    const auto samples = static_cast<double>(cache_.info().sample_count);
    EXPECT_NEAR(number(row, "samples_per_s") * seconds / samples, 1, 1e-9);
    if (names.back() == "reduce-strong-kmeans" || names.back() == "pack") {
      const auto records = static_cast<double>(cache_.info().record_count);
      EXPECT_NEAR(number(row, "records_per_s") * seconds / records, 1, 1e-9);
    }
    EXPECT_EQ(find(row, "floor_ms"), nullptr) << "these stages have no floor";
  }
  EXPECT_EQ(names, (std::vector<std::string>{"sample", "reduce-kmeans", "reduce-strong-kmeans",
                                             "reduce-light-fit-fast", "reduce-light-fit", "pack",
                                             "write-cache"}));
  const auto bytes = static_cast<double>(cache_.size_bytes());
  const auto records = static_cast<double>(cache_.info().record_count);
  EXPECT_NEAR(number(rows.back(), "bytes_per_record"), bytes / records, 1e-9);
}

TEST_F(BenchStages, TakeFewerTilesWhereAReductionIsSlow) {
  const std::vector<FigureRow> rows = run(1e-3);
  EXPECT_EQ(number(rows[0], "pixels"), width * height);
  for (size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(number(rows[i], "pixels"), 16 * 16 * 16) << i;
    EXPECT_GT(number(rows[i], "records_per_s"), 0) << i << ": tiles spread over the picture";
  }
}

}  // namespace
}  // namespace relume

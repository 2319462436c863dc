// A study that is killed goes on where it was, and its files are the same to the byte.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

int run_shell(const TemporaryFolder& folder, const std::string& script) {
  const int status =
      std::system(("cd '" + folder.path().string() + "' || exit 1; " + script).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// A study that takes a second or so, and what it is told.
struct SmallStudy {
  const char* name;
  const char* options;
};
constexpr SmallStudy rates{"rates",
                           "spheres --methods kmeans pure --records 4 2 --lights 2 --spp 9 "
                           "--width 160 --height 160"};
constexpr SmallStudy studies[] = {
    {"methods",
     "spheres --methods kmeans light-metric-4 --train-shadows --training-lights 16 --lights 2 "
     "--spp 9 --width 160 --height 160"},
    rates,
    {"lights", "spheres --methods light-metric-4 --lights 2 --spp 4 --width 144 --height 144"},
    {"smooth", "--methods kmeans pure --width 128 --height 128 --spp 9"},
    {"pictures", "spheres --methods kmeans pure --width 128 --height 128 --spp 9"},
    {"shadows",
     "spheres --methods kmeans --records 2 1 --truth-spp 16 --spp 9 --width 80 --height 80 "
     "--pictures"},
    {"tradeoff",
     "spheres --methods kmeans --shadows none ray volume --records 2 --average-records 0 "
     "--lights 2 --truth-spp 16 --spp 9 --width 80 --height 80"},
    {"stability", "spheres --quick --spp 4"},
};

std::string run(const SmallStudy& study, const std::string& options) {
  return fmt::format("'{}' study {} {} -o {}", RELUME_PROGRAM, study.name, study.options, options);
}

/// Kills the study that runs in the background once its log in `folder` has `lines` lines.
std::string kill_after(const SmallStudy& study, const std::string& folder, int lines) {
  return fmt::format(
      " for i in $(seq 4000); do [ $(cat {}/{}.trials 2>/dev/null | wc -l) -ge {} ] && break; "
      "sleep 0.002; done; kill -KILL $!; wait $!; true",
      folder, study.name, lines);
}

/// The text without what differs from run to run: how long things took, what was chosen by that,
/// and the ray tracer's memory.
std::string without_times(const std::filesystem::path& file) {
  const std::string text = read_all(file);
  if (file.extension() != ".json") return text;
  auto document = nlohmann::json::parse(text);
  document.erase("recommended");
  for (auto& row : document["rows"]) {
    for (const char* field : {"ms_light", "ms_prepare", "pareto", "structure_bytes"}) {
      row.erase(field);
    }
  }
  return document.dump();
}

bool is_timed(const std::string& study) {
  return study == "tradeoff" || study == "shadows";
}

class KilledStudy : public testing::TestWithParam<SmallStudy> {};

TEST_P(KilledStudy, GoesOnAndWritesTheSame) {
  const SmallStudy& study = GetParam();
  const std::string log = std::string(study.name) + ".trials";
  const std::string json = std::string(study.name) + ".json";
  const TemporaryFolder folder;
  ASSERT_EQ(run_shell(folder, run(study, "whole >/dev/null 2>&1")), 0);
  EXPECT_FALSE(std::filesystem::exists(folder.file("whole") / log))
      << "a complete study needs no log";

  ASSERT_EQ(
      run_shell(folder, run(study, "killed >/dev/null 2>&1 &") + kill_after(study, "killed", 3)),
      0);
  ASSERT_TRUE(std::filesystem::exists(folder.file("killed") / log));
  EXPECT_FALSE(std::filesystem::exists(folder.file("killed") / json));
  ASSERT_EQ(run_shell(folder, run(study, "killed >/dev/null 2>stderr.txt")), 0);
  EXPECT_NE(read_all(folder.file("stderr.txt")).find("goes on after"), std::string::npos);

  int compared = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.file("whole"))) {
    const std::filesystem::path name = entry.path().filename();
    if (is_timed(study.name) && (name.extension() == ".csv" || name.extension() == ".html")) {
      continue;
    }
    EXPECT_TRUE(without_times(entry.path()) == without_times(folder.file("killed") / name)) << name;
    ++compared;
  }
  EXPECT_GE(compared, is_timed(study.name) ? 1 : 3);
}

INSTANTIATE_TEST_SUITE_P(Study, KilledStudy, testing::ValuesIn(studies),
                         [](const auto& study) { return std::string(study.param.name); });

TEST(Study, TakesNothingFromALogOfOtherSettings) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_shell(folder, run(rates, "mixed --seed 1 >/dev/null 2>&1 &") +
                                  kill_after(rates, "mixed", 2)),
            0);
  ASSERT_TRUE(std::filesystem::exists(folder.file("mixed") / "rates.trials"));
  ASSERT_EQ(run_shell(folder, run(rates, "mixed --seed 2 >/dev/null 2>&1")), 0);
  ASSERT_EQ(run_shell(folder, run(rates, "whole --seed 2 >/dev/null 2>&1")), 0);
  EXPECT_EQ(read_all(folder.file("mixed") / "rates-trials.csv"),
            read_all(folder.file("whole") / "rates-trials.csv"));
}

}  // namespace
}  // namespace relume::test

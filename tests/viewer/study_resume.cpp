// A study that is killed goes on where it was, and its files are the same to the byte.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>

#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

const char* const study =
    " study rates spheres --methods kmeans pure --records 4 2 --lights 2 --spp 9 "
    "--width 192 --height 192 -o ";

int run_shell(const TemporaryFolder& folder, const std::string& script) {
  const int status =
      std::system(("cd '" + folder.path().string() + "' || exit 1; " + script).c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string run(const std::string& options) {
  return std::string("'") + RELUME_PROGRAM + "'" + study + options;
}

/// Kills the study that runs in the background once its log in `name` has `lines` lines.
std::string kill_after(const std::string& name, int lines) {
  return fmt::format(
      " for i in $(seq 2000); do [ $(cat {}/rates.trials 2>/dev/null | wc -l) -ge {} ] && break; "
      "sleep 0.005; done; kill -KILL $!; wait $!; true",
      name, lines);
}

TEST(Study, GoesOnAfterAKillAndWritesTheSameBytes) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_shell(folder, run("whole >/dev/null 2>&1")), 0);
  EXPECT_FALSE(std::filesystem::exists(folder.file("whole") / "rates.trials"))
      << "a complete study needs no log";

  ASSERT_EQ(run_shell(folder, run("killed >/dev/null 2>&1 &") + kill_after("killed", 3)), 0);
  ASSERT_TRUE(std::filesystem::exists(folder.file("killed") / "rates.trials"));
  EXPECT_FALSE(std::filesystem::exists(folder.file("killed") / "rates.json"));
  ASSERT_EQ(run_shell(folder, run("killed >/dev/null 2>stderr.txt")), 0);
  EXPECT_NE(read_all(folder.file("stderr.txt")).find("goes on after"), std::string::npos);

  for (const char* file :
       {"rates.json", "rates.csv", "rates-pairs.csv", "rates-trials.csv", "rates.html"}) {
    const std::string whole = read_all(folder.file("whole") / file);
    EXPECT_GT(whole.size(), 100u) << file;
    EXPECT_TRUE(whole == read_all(folder.file("killed") / file)) << file;
  }
}

TEST(Study, TakesNothingFromALogOfOtherSettings) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_shell(folder, run("mixed --seed 1 >/dev/null 2>&1 &") + kill_after("mixed", 2)), 0);
  ASSERT_TRUE(std::filesystem::exists(folder.file("mixed") / "rates.trials"));
  ASSERT_EQ(run_shell(folder, run("mixed --seed 2 >/dev/null 2>&1")), 0);
  ASSERT_EQ(run_shell(folder, run("whole --seed 2 >/dev/null 2>&1")), 0);
  EXPECT_EQ(read_all(folder.file("mixed") / "rates-trials.csv"),
            read_all(folder.file("whole") / "rates-trials.csv"));
}

}  // namespace
}  // namespace relume::test

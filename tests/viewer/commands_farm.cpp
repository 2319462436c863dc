// Commands under Open MPI: the same bytes as one process, also when a rank is killed.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <map>

#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

/// A command whose output is `output`, a file or a folder, in a folder that starts empty.
struct SharedCommand {
  const char* name;
  const char* options;
  const char* output;
};
constexpr SharedCommand commands[] = {
    {"prepare",
     "prepare spheres --width 256 --height 256 --spp 9 --records 3 --members 4 --seed 5 "
     "-o out/spheres.relume",
     "out/spheres.relume"},
    {"study",
     "study rates spheres --methods kmeans pure --records 2 --lights 2 --spp 4 --width 224 "
     "--height 224 --threads 1 -o out/rates",
     "out/rates/rates.trials"},
    {"render",
     "render spheres --frames 1-40 --lights lights.json --width 40 --height 40 --spp 4 --records 2 "
     "-o out/frame.##.exr",
     "out/frame.##.exr"},
};

class OpenMpi : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v mpirun >/dev/null") != 0) GTEST_SKIP() << "no mpirun";
    write_all(folder_.file("lights.json"),
              R"({"lights": [{"name": "key", "position": [0, 4, 3], "gain": 20,
                  "turntable": {"center": [0, 0, 0], "frames": [1, 7]}}]})");
    std::filesystem::create_directory(folder_.file("out"));
  }

  int run_shell(const std::string& script) const {
    const int status =
        std::system(("cd '" + folder_.path().string() + "' || exit 1; " + script).c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  int run(const std::string& options) const {
    return run_shell(fmt::format("'{}' {} -q >stdout 2>stderr", RELUME_PROGRAM, options));
  }

  static std::string mpirun(int ranks, const std::string& options = "") {
    return fmt::format("mpirun --allow-run-as-root --oversubscribe --bind-to none -n {} {} ", ranks,
                       options);
  }

  int run_ranks(int ranks, const std::string& options) const {
    return run_shell(
        fmt::format("{} '{}' {} >stdout 2>stderr", mpirun(ranks), RELUME_PROGRAM, options));
  }

  enum class Killed { last_rank, all_ranks };

  /// Starts three ranks, which stand still from the first result until the last has joined, and
  /// kills that one, or all; the launcher's exit code. Each rank leaves its process id behind.
  int run_and_kill(const SharedCommand& command, Killed killed) const {
    const bool is_all = killed == Killed::all_ranks;
    const std::string start = fmt::format(
        "rm -f pid.*; {} sh -c 'echo $$ >pid.$OMPI_COMM_WORLD_RANK; exec {} {} -q' >stdout "
        "2>stderr &\n",
        mpirun(3, is_all ? "" : "--enable-recovery"), RELUME_PROGRAM, command.options);
    const std::string kill = fmt::format(
        "while [ ! -e {0}.work/0.000000 ] && kill -0 $!; do :; done\n"
        "kill -STOP $(cat pid.0 pid.1)\n"
        "while [ $(stat -c %s {0}.work/members) -lt 19 ] && kill -0 $!; do :; done\n"
        "kill -KILL $(cat pid.2 {1}); kill -CONT $(cat pid.0 pid.1); wait $!\n",
        command.output, is_all ? "pid.0 pid.1" : "");
    return run_shell(start + "{ " + kill + "} 2>/dev/null");
  }

  /// Everything in the folder of results, by name, but what a killed process was writing.
  std::map<std::string, std::string> take_results() const {
    std::map<std::string, std::string> results;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_.file("out"))) {
      const bool is_cut_short = entry.path().extension().string().starts_with(".relume-tmp-");
      if (!entry.is_regular_file() || is_cut_short) continue;
      results[entry.path().string()] = read_all(entry.path());
    }
    std::filesystem::remove_all(folder_.file("out"));
    std::filesystem::create_directory(folder_.file("out"));
    return results;
  }

  std::string told() const { return read_all(folder_.file("stderr")); }

  TemporaryFolder folder_;
};

class SharedCommands : public OpenMpi, public testing::WithParamInterface<SharedCommand> {};

TEST_P(SharedCommands, GiveTheSameBytesFromAnyNumberOfRanks) {
  ASSERT_EQ(run(GetParam().options), 0) << told();
  const auto expected = take_results();
  ASSERT_FALSE(expected.empty());
  for (const int ranks : {1, 2, 3}) {
    ASSERT_EQ(run_ranks(ranks, GetParam().options), 0) << told();
    EXPECT_TRUE(take_results() == expected) << ranks;
  }
}

TEST_P(SharedCommands, SurviveARankThatIsKilled) {
  ASSERT_EQ(run(GetParam().options), 0) << told();
  const auto expected = take_results();
  EXPECT_EQ(run_and_kill(GetParam(), Killed::last_rank), 0) << told();
  EXPECT_TRUE(take_results() == expected);
}

TEST_P(SharedCommands, GoOnAloneAfterAllRanksWereKilled) {
  ASSERT_EQ(run(GetParam().options), 0) << told();
  const auto expected = take_results();
  const auto results = folder_.file(GetParam().output).string() + ".work";
  // On a machine busy with other things a small job may be over before anything is killed.
  for (int attempt = 0; attempt < 5 && !std::filesystem::exists(results); ++attempt) {
    take_results();
    run_and_kill(GetParam(), Killed::all_ranks);
  }
  ASSERT_TRUE(std::filesystem::exists(results)) << "killed too late";
  ASSERT_EQ(run(GetParam().options), 0) << told();
  EXPECT_FALSE(std::filesystem::exists(results));
  EXPECT_TRUE(take_results() == expected);
}

INSTANTIATE_TEST_SUITE_P(OpenMpi, SharedCommands, testing::ValuesIn(commands),
                         [](const auto& command) { return std::string(command.param.name); });

TEST_F(OpenMpi, ErrorsAreToldOnceAndKeepTheirExitCode) {
  const auto count = [this](const std::string& part) {
    int found = 0;
    const std::string text = told();
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
      ++found;
    }
    return found;
  };
  EXPECT_EQ(run_ranks(3, "prepare none.json -o out/a.relume"), 3);
  EXPECT_LE(count("relume: none.json"), 1) << "a rank may end before the first has told";
  EXPECT_EQ(run_ranks(3, "prepare spheres"), 2);
  EXPECT_LE(count("required"), 1);
  EXPECT_EQ(run_ranks(2, "prepare spheres --width 32 --height 32 -o none/a.relume"), 5);
  EXPECT_GE(count("none/a.relume"), 1);
  EXPECT_EQ(run_ranks(2, "info spheres"), 0);
  EXPECT_EQ(count("one does it"), 1);
  const std::string printed = read_all(folder_.file("stdout"));
  EXPECT_NE(printed.find("width "), std::string::npos);
  EXPECT_EQ(printed.find("width "), printed.rfind("width "));
  EXPECT_TRUE(take_results().empty());
}

}  // namespace
}  // namespace relume::test

// Processes that share work through a folder: here objects of one process, and a child that dies.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <span>
#include <thread>

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "viewer/farm/shared_work.h"

namespace relume::test {
namespace {

SharedWork::Bytes bytes_of(const std::string& text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

SharedWork::Bytes square(size_t item) {
  return bytes_of(fmt::format("{}", item * item));
}

class Farm : public testing::Test {
 protected:
  SharedWork join(int rank, int size, const std::string& settings = "same") const {
    return {work_, settings, {.rank = rank, .size = size, .local_size = size}};
  }

  TemporaryFolder folder_;
  std::filesystem::path work_ = work_folder(folder_.file("out"));
};

TEST_F(Farm, EachItemIsMadeOnceAndAllHaveIt) {
  constexpr int ranks = 4;
  constexpr size_t items = 60;
  std::vector<std::atomic<int>> made(items);
  std::atomic<int> finished{0};
  const auto run = [&](int rank) {
    SharedWork work = join(rank, ranks);
    for (int stage = 0; stage < 2; ++stage) {
      const int number = work.complete("squares", items,
                                       [&](size_t item) {
                                         ++made[item];
                                         std::this_thread::yield();
                                         return square(item + stage);
                                       },
                                       {});
      for (size_t i = 0; i < items; ++i) {
        EXPECT_EQ(work.result(number, i), square(i + stage)) << rank << " " << i;
      }
    }
    work.finish([&] { ++finished; });
    EXPECT_EQ(finished, 1) << rank;
  };
  std::vector<std::thread> threads;
  for (int rank = 0; rank < ranks; ++rank) threads.emplace_back(run, rank);
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < items; ++i) EXPECT_EQ(made[i], 2) << i;
  EXPECT_EQ(folder_.entry_count(), 0u);
}

TEST_F(Farm, WhatADeadProcessHeldIsMadeByAnother) {
  const std::filesystem::path started = folder_.file("started");
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    SharedWork work = join(1, 2);
    work.complete("", 3,
                  [&](size_t) -> SharedWork::Bytes {
                    write_all(started, "yes");
                    for (;;) pause();
                  },
                  {});
    _exit(1);
  }
  while (!std::filesystem::exists(started)) std::this_thread::yield();
  SharedWork work = join(0, 2);
  std::vector<size_t> made;
  const auto make = [&](size_t item) {
    made.push_back(item);
    if (made.size() == 2) kill(child, SIGKILL);  // all others are done
    return square(item);
  };
  const int stage = work.complete("", 3, make, {});
  EXPECT_EQ(made, (std::vector<size_t>{1, 2, 0})) << "the first was held until then";
  EXPECT_EQ(work.result(stage, 0), square(0));
  int status = 0;
  waitpid(child, &status, 0);
  bool is_last_done = false;
  work.finish([&] { is_last_done = true; });
  EXPECT_TRUE(is_last_done);
  EXPECT_FALSE(std::filesystem::exists(work_));
}

TEST_F(Farm, GoesOnWhereItWasStopped) {
  size_t made = 0;
  const auto make = [&](size_t item) {
    if (++made == 4) throw Error(ErrorKind::limit, "stopped");
    return square(item);
  };
  EXPECT_THROW(join(0, 1).complete("", 6, make, {}), Error);
  EXPECT_TRUE(is_shared(folder_.file("out"), {})) << "alone, but there is something to go on with";
  SharedWork work = join(0, 1);
  const int stage = work.complete("", 6, make, {});
  EXPECT_EQ(made, 4u + 3u);
  for (size_t i = 0; i < 6; ++i) EXPECT_EQ(work.result(stage, i), square(i)) << i;
}

TEST_F(Farm, TakesNothingFromOtherSettings) {
  { join(0, 1).complete("", 2, square, {}); }
  size_t made = 0;
  SharedWork work = join(0, 1, "other");
  work.complete("", 2,
                [&](size_t item) {
                  ++made;
                  return square(item);
                },
                {});
  EXPECT_EQ(made, 2u);
  EXPECT_ERROR(join(1, 2), ErrorKind::output, "another command is at work");
}

TEST_F(Farm, WhenTheLastPartFailsAnotherDoesIt) {
  SharedWork first = join(0, 2);
  SharedWork second = join(1, 2);
  EXPECT_THROW(first.finish([] { throw Error(ErrorKind::output, "disk full"); }), Error);
  std::atomic<int> done{0};
  std::thread other([&] { second.finish([&] { ++done; }); });
  first.finish([&] { ++done; });
  other.join();
  EXPECT_EQ(done, 1);
}

TEST_F(Farm, DamagedResultsAreRefused) {
  SharedWork work = join(0, 1);
  const int stage = work.complete("", 1, square, {});
  for (const auto& entry : std::filesystem::directory_iterator(work_)) {
    if (entry.path().extension() != ".000000") continue;
    std::string text = read_all(entry.path());
    text[0] ^= 1;
    write_all(entry.path(), text);
    EXPECT_ERROR(work.result(stage, 0), ErrorKind::input, "is damaged");
    write_all(entry.path(), "");
    EXPECT_ERROR(work.result(stage, 0), ErrorKind::input, "is damaged");
  }
}

TEST_F(Farm, FoldersThatCannotBeMadeAreTold) {
  work_ = folder_.file("none") / "out.work";
  EXPECT_ERROR(join(0, 1), ErrorKind::output, "out.work");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("none")));
}

class Launcher : public testing::Test {
 protected:
  Launcher() {
    for (const char* name : names) unsetenv(name);
  }
  ~Launcher() override {
    for (const char* name : names) unsetenv(name);
  }
  static constexpr const char* names[] = {"RELUME_RANK",
                                          "RELUME_RANKS",
                                          "RELUME_LOCAL_RANKS",
                                          "OMPI_COMM_WORLD_RANK",
                                          "OMPI_COMM_WORLD_SIZE",
                                          "OMPI_COMM_WORLD_LOCAL_SIZE",
                                          "PMI_RANK",
                                          "PMI_SIZE",
                                          "MPI_LOCALNRANKS"};
};

TEST_F(Launcher, TellsRankAndSize) {
  EXPECT_TRUE(team_from_environment().is_alone());
  setenv("PMI_RANK", "2", 1);
  setenv("PMI_SIZE", "3", 1);
  EXPECT_EQ(team_from_environment().rank, 2);
  setenv("OMPI_COMM_WORLD_RANK", "4", 1);
  setenv("OMPI_COMM_WORLD_SIZE", "8", 1);
  setenv("OMPI_COMM_WORLD_LOCAL_SIZE", "4", 1);
  const Team team = team_from_environment();
  EXPECT_EQ(team.rank, 4);
  EXPECT_EQ(team.size, 8);
  EXPECT_EQ(team.local_size, 4);
  for (const char* wrong : {"8", "-1", "x", "", "1e9"}) {
    setenv("OMPI_COMM_WORLD_RANK", wrong, 1);
    EXPECT_ERROR(team_from_environment(), ErrorKind::usage, "OMPI_COMM_WORLD_RANK");
  }
}

TEST_F(Launcher, ProcessesOfOneMachineShareItsProcessors) {
  const int all = share_of_processors({});
  ASSERT_GE(all, 1);
  EXPECT_EQ(share_of_processors({.rank = 0, .size = 4, .local_size = 1}), all);
  EXPECT_EQ(share_of_processors({.rank = 0, .size = 10000, .local_size = 10000}), 1);
  EXPECT_LE(2 * share_of_processors({.rank = 1, .size = 2, .local_size = 2}), std::max(2, all));
}

}  // namespace
}  // namespace relume::test

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace relume {
namespace {

class Parallel : public testing::TestWithParam<int> {
 protected:
  void SetUp() override { set_thread_count(GetParam()); }
  void TearDown() override { set_thread_count(0); }
};

TEST_P(Parallel, CoversTheRangeOnce) {
  for (const size_t count : {size_t{0}, size_t{1}, size_t{2}, size_t{7}, size_t{1000}}) {
    for (const size_t grain : {size_t{0}, size_t{1}, size_t{3}, size_t{5000}}) {
      std::vector<std::atomic<int>> visits(count);
      parallel_for(count, grain, [&](size_t begin, size_t end) {
        EXPECT_LT(begin, end);
        for (size_t i = begin; i < end; ++i) ++visits.at(i);
      });
      for (size_t i = 0; i < count; ++i) EXPECT_EQ(visits[i], 1) << i << " of " << count;
    }
  }
}

TEST_P(Parallel, RethrowsTheException) {
  const auto body = [](size_t begin, size_t end) {
    if (begin <= 500 && 500 < end) throw std::runtime_error("item 500");
  };
  try {
    parallel_for(1000, 1, body);
    FAIL() << "no exception";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "item 500");
  }
}

TEST_P(Parallel, WorksAfterAnException) {
  EXPECT_THROW(parallel_for(10, 1, [](size_t, size_t) { throw 1; }), int);
  std::atomic<size_t> sum = 0;
  parallel_for(100, 1, [&](size_t begin, size_t end) { sum += end - begin; });
  EXPECT_EQ(sum, 100u);
}

TEST_P(Parallel, NestsWithoutDeadlock) {
  std::atomic<size_t> sum = 0;
  parallel_for(8, 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      parallel_for(100, 1, [&](size_t b, size_t e) { sum += e - b; });
    }
  });
  EXPECT_EQ(sum, 800u);
}

TEST_P(Parallel, RunsAtMostTheThreadsAskedFor) {
  std::atomic<int> running = 0;
  std::atomic<int> most = 0;
  parallel_for(64, 1, [&](size_t begin, size_t end) {
    const int now = ++running;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(end - begin));
    --running;
  });
  EXPECT_GE(most, 1);
  EXPECT_LE(most, thread_count());
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(0, 1, 2, 3, 8));

TEST(ThreadCount, IsTheOneAskedForOrAtLeastOne) {
  set_thread_count(3);
  EXPECT_EQ(thread_count(), 3);
  set_thread_count(0);
  EXPECT_GE(thread_count(), 1);
  set_thread_count(-5);
  EXPECT_GE(thread_count(), 1);
  set_thread_count(0);
}

TEST(ThreadCount, ManyThreadsReallyRunAtOnce) {
  // Determinism tests with eight threads mean nothing when a loop only ever uses two.
  set_thread_count(8);
  std::atomic<int> running = 0;
  std::atomic<int> most = 0;
  parallel_for(64, 1, [&](size_t, size_t) {
    const int now = ++running;
    int seen = most;
    while (now > seen && !most.compare_exchange_weak(seen, now)) {
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    --running;
  });
  set_thread_count(0);
  EXPECT_GT(most, 2);
}

}  // namespace
}  // namespace relume

#include "core/base/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>

#include "core/base/thread_sanitizer.h"

// This file is compiled without ThreadSanitizer and tells it two edges: fork before body, body
// before join.

namespace relume {
namespace {

int limit_from_user = 0;

/// Where a body ends, by an exception too.
struct JoinEdge {
  char& edge;
  ~JoinEdge() { __tsan_release(&edge); }
};

/// Where those that wait go on, by an exception too.
struct WaitEdge {
  char& edge;
  ~WaitEdge() { __tsan_acquire(&edge); }
};

/// The user's threads. The arena is what lets a loop use more of them than the machine has, which
/// tests of determinism need; the control holds for Embree's loops too.
struct Threads {
  tbb::global_control limit;
  tbb::task_arena arena;
  explicit Threads(int count)
      : limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(count)),
        arena(count) {}
};

std::unique_ptr<Threads>& user_threads() {
  static std::unique_ptr<Threads> threads;
  return threads;
}

/// Runs `loop` on the user's threads, or on all.
template <class Loop>
void run(const Loop& loop) {
  // Isolated: a thread that waits here does not pick up another loop's work while it holds locks.
  if (const auto& threads = user_threads()) {
    threads->arena.execute([&] { tbb::this_task_arena::isolate(loop); });
  } else {
    tbb::this_task_arena::isolate(loop);
  }
}

}  // namespace

void set_thread_count(int count) {
  limit_from_user = std::max(0, count);
  user_threads().reset();
  if (limit_from_user > 0) user_threads() = std::make_unique<Threads>(limit_from_user);
}

int thread_count() {
  return limit_from_user > 0 ? limit_from_user : tbb::info::default_concurrency();
}

void parallel_for(size_t count, size_t grain,
                  const std::function<void(size_t begin, size_t end)>& body) {
  if (count == 0) return;
  char fork_edge = 0;
  char join_edge = 0;
  __tsan_release(&fork_edge);
  const WaitEdge wait{join_edge};
  run([&] {
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, std::max<size_t>(1, grain)),
                      [&](const tbb::blocked_range<size_t>& range) {
                        const JoinEdge join{join_edge};
                        __tsan_acquire(&fork_edge);
                        body(range.begin(), range.end());
                      });
  });
}

}  // namespace relume

// Shows what ThreadSanitizer sees of our parallel loops, whose threads come from a library that is
// not instrumented. Usage: injected_race race|none
// race: two bodies of one loop write the same variable; a report must come. none: each body writes
// a place of its own, all are read behind the loop, and loops nest; no report may come.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace {

long shared_sum = 0;

/// Waits until another body of the loop runs, for a second at most. Relaxed: no edge between them.
void meet(std::atomic<int>& running) {
  running.fetch_add(1, std::memory_order_relaxed);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(1);
  while (running.load(std::memory_order_relaxed) < 2 && std::chrono::steady_clock::now() < end) {
    std::this_thread::yield();
  }
}

void race() {
  std::atomic<int> running{0};
  relume::parallel_for(8, 1, [&](size_t begin, size_t end) {
    meet(running);
    shared_sum += static_cast<long>(end - begin);
  });
}

void no_race() {
  constexpr size_t count = 64;
  std::vector<long> values(count * count);
  for (int round = 0; round < 20; ++round) {
    relume::parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        relume::parallel_for(count, 8, [&, i](size_t from, size_t to) {
          for (size_t j = from; j < to; ++j) values[i * count + j] += round;
        });
      }
    });
    for (const long value : values) shared_sum += value;
  }
}

}  // namespace

int main(int count, char** arguments) {
  relume::set_thread_count(4);
  const bool is_race = count > 1 && std::strcmp(arguments[1], "race") == 0;
  is_race ? race() : no_race();
  std::printf("%ld\n", shared_sum);
}

// Faults that a sanitized build must report. Usage: injected_fault FAULT
// race: two bodies of one parallel loop write the same variable; their threads come from a library
// that is not instrumented. beyond, leak, cast, divide: memory behind a vector is read, an
// allocation is lost, a float beyond all integers becomes one, a float is divided by zero. none: no
// report may come; bodies of loops write places of their own, all are read behind the loop, and
// loops nest.

#include <atomic>
#include <chrono>
#include <cstdio>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace {

long shared_sum = 0;
volatile float zero = 0;  // what follows must not be computed by the compiler

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

void read_beyond() {
  const std::vector<int> values(4 + static_cast<size_t>(zero));
  shared_sum += values.data()[values.size()];
}

void leak() {
  volatile char* lost = new char[1000];
  lost[0] = 1;
  lost = nullptr;
}

void cast() {
  shared_sum += static_cast<int>(1e20f + zero);
}

void divide() {
  shared_sum += 1 / zero > 1;
}

void no_fault() {
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

constexpr struct {
  std::string_view name;
  void (*run)();
} faults[] = {{"race", race}, {"beyond", read_beyond}, {"leak", leak},
              {"cast", cast}, {"divide", divide},      {"none", no_fault}};

}  // namespace

int main(int count, char** arguments) {
  relume::set_thread_count(4);
  for (const auto& fault : faults) {
    if (count != 2 || fault.name != arguments[1]) continue;
    fault.run();
    std::printf("%ld\n", shared_sum);
    return 0;
  }
  std::fprintf(stderr, "usage: injected_fault race|beyond|leak|cast|divide|none\n");
  return 2;
}

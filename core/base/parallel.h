#pragma once

#include <cstddef>
#include <functional>

namespace relume {

/// Limits every parallel loop of the process to `count` threads (0 = all hardware threads). Call it
/// once, before the first loop.
void set_thread_count(int count);

/// The number of threads that parallel loops use now, >= 1.
int thread_count();

/// Runs body(begin, end) over disjoint sub-ranges that cover [0, count), each at least `grain` long
/// where possible, on the process's threads. Blocks until all are done. The first exception thrown
/// by a body is rethrown here and the ranges not yet started are skipped. Nothing may depend on how
/// the range is cut: results must be the same for body(0, count).
void parallel_for(size_t count, size_t grain,
                  const std::function<void(size_t begin, size_t end)>& body);

}  // namespace relume

#pragma once

#include <chrono>

namespace relume {

/// Wall-clock stopwatch (monotonic).
class Timer {
 public:
  Timer() : start_(Clock::now()) {}
  /// Milliseconds since construction.
  double ms() const {
    return std::chrono::duration<double, std::milli>(Clock::now() - start_).count();
  }
  double seconds() const { return ms() * 1e-3; }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_;
};

}  // namespace relume

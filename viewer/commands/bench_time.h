#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <vector>

#include "core/base/timer.h"

namespace relume {

/// Least wall time in milliseconds of `repeats` calls, of fewer once they took `enough_ms` together
/// (at least one).
template <class Body>
double least_ms(int repeats, const Body& body,
                double enough_ms = std::numeric_limits<double>::infinity()) {
  double least = std::numeric_limits<double>::infinity();
  double total = 0;
  for (int i = 0; i < repeats && total < enough_ms; ++i) {
    const Timer timer;
    body();
    const double ms = timer.ms();
    least = std::min(least, ms);
    total += ms;
  }
  return least;
}

/// The same for bodies that are compared: they take turns, so that a machine that slows down does
/// so for all. In its turn a body runs once before it is timed, as if it had run all the time.
inline std::vector<double> least_ms_in_turn(int repeats,
                                            const std::vector<std::function<void()>>& bodies) {
  std::vector<double> least(bodies.size(), std::numeric_limits<double>::infinity());
  for (int i = 0; i < repeats; ++i) {
    for (size_t j = 0; j < bodies.size(); ++j) {
      bodies[j]();
      least[j] = std::min(least[j], least_ms(1, bodies[j]));
    }
  }
  return least;
}

}  // namespace relume

#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "core/base/timer.h"

namespace relume {

/// How far a long stage is: called from one thread at a time, at most about ten times a second and
/// once at the end. `fraction` in [0, 1]; `seconds_left` < 0 while unknown. Returning false asks
/// the stage to stop; it then throws Error(cancelled) and leaves nothing half-written.
using ProgressCallback =
    std::function<bool(const std::string& stage, double fraction, double seconds_left)>;

/// A callback that draws a bar with the time left on stderr when that is a terminal, and one line a
/// stage otherwise. Returns false after SIGINT was seen by install_interrupt_handler().
ProgressCallback make_terminal_progress(bool quiet);

/// Makes SIGINT and SIGTERM request a clean stop instead of killing the process; a second signal
/// kills. A file above the user's limit (`ulimit -f`) is an error of the write and kills nothing.
/// Process-wide.
void install_interrupt_handler();

/// True once SIGINT or SIGTERM arrived.
bool interrupted();

/// Feeds a ProgressCallback from a loop. Not thread-safe: report between parallel loops.
class Progress {
 public:
  Progress(ProgressCallback callback, std::string stage);
  /// Reports `done` of `total` units. Throws Error(cancelled) when the callback asks to stop.
  void update(double done, double total);

 private:
  ProgressCallback callback_;
  std::string stage_;
  Timer timer_;
  double last_report_ms_ = -1e9;
};

}  // namespace relume

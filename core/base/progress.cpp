#include "core/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <utility>

#include "core/base/error.h"

namespace relume {
namespace {

volatile std::sig_atomic_t interrupt_seen = 0;

void on_signal(int signal) {
  interrupt_seen = 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void install_interrupt_handler() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool interrupted() {
  return interrupt_seen != 0;
}

ProgressCallback make_terminal_progress(bool quiet) {
  const bool is_terminal = isatty(STDERR_FILENO) != 0;
  return [quiet, is_terminal](const std::string& stage, double fraction, double seconds_left) {
    if (quiet || (!is_terminal && fraction < 1)) return !interrupted();
    constexpr int width = 30;
    const int filled = static_cast<int>(fraction * width + 0.5);
    const std::string left =
        seconds_left >= 0 && fraction < 1 ? fmt::format("{:.0f} s left", seconds_left) : "";
    fmt::print(stderr, "{}{:<22} [{:=<{}}{:<{}}] {:3.0f} % {:<14}{}", is_terminal ? "\r" : "",
               stage, "", filled, "", width - filled, 100 * fraction, left,
               fraction >= 1 ? "\n" : "");
    std::fflush(stderr);
    return !interrupted();
  };
}

Progress::Progress(ProgressCallback callback, std::string stage)
    : callback_(std::move(callback)), stage_(std::move(stage)) {}

void Progress::update(double done, double total) {
  if (!callback_) return;
  const bool finished = done >= total;
  const double now_ms = timer_.ms();
  if (!finished && now_ms - last_report_ms_ < 100) return;
  last_report_ms_ = now_ms;
  const double fraction = total > 0 ? std::clamp(done / total, 0.0, 1.0) : 1.0;
  const double seconds_left = fraction > 0.01 ? now_ms * 1e-3 * (1 - fraction) / fraction : -1.0;
  if (!callback_(stage_, fraction, seconds_left)) {
    throw Error(ErrorKind::cancelled, stage_ + ": interrupted; nothing was written");
  }
}

}  // namespace relume

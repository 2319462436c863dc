#include "core/base/check.h"

#include <cstdio>
#include <cstdlib>
#include <mutex>

namespace relume {
namespace {

std::mutex events_mutex;
const RareEvent* first_event = nullptr;

}  // namespace

void check_failed(const char* file, int line, const std::string& message) {
  std::fprintf(stderr, "%s:%d: %s\n", file, line, message.c_str());
  std::fflush(stderr);
  std::abort();
}

void RareEvent::add(uint64_t n) {
  if (n == 0) return;
  count_.fetch_add(n, std::memory_order_relaxed);
  if (listed_.exchange(true, std::memory_order_acq_rel)) return;
  const std::lock_guard lock(events_mutex);
  next_ = first_event;
  first_event = this;
}

std::string rare_events() {
  const std::lock_guard lock(events_mutex);
  std::string text;
  for (const RareEvent* event = first_event; event != nullptr; event = event->next()) {
    text += fmt::format("{}: {}\n", event->name(), event->count());
  }
  return text;
}

}  // namespace relume

#pragma once

#include <fmt/format.h>

#include <atomic>
#include <cstdint>
#include <string>

namespace relume {

/// Prints `message` to stderr and aborts. Used by the CHECK macros only.
[[noreturn]] void check_failed(const char* file, int line, const std::string& message);

/// A named counter of a rare event (a guard that fired, a value that was replaced). Constant
/// initialised, thread-safe, relaxed. Every counter that ever fired is listed by rare_events().
class RareEvent {
 public:
  constexpr explicit RareEvent(const char* name) : name_(name) {}

  /// Counts `n` more occurrences.
  void add(uint64_t n = 1);
  uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  const char* name() const { return name_; }
  const RareEvent* next() const { return next_; }

 private:
  const char* name_;
  std::atomic<uint64_t> count_{0};
  std::atomic<bool> listed_{false};
  const RareEvent* next_ = nullptr;
};

/// "name: count" of every RareEvent that fired in this process, one a line; empty if none did.
std::string rare_events();

}  // namespace relume

/// A contract of our own code: prints the expression and aborts when it is false. Always on.
#define CHECK(cond)                                                       \
  do {                                                                    \
    if (!(cond)) [[unlikely]]                                             \
      ::relume::check_failed(__FILE__, __LINE__, "CHECK failed: " #cond); \
  } while (0)

/// CHECK with values: CHECK_MSG(i < n, "i {} n {}", i, n).
#define CHECK_MSG(cond, ...)                                                          \
  do {                                                                                \
    if (!(cond)) [[unlikely]]                                                         \
      ::relume::check_failed(__FILE__, __LINE__,                                      \
                             "CHECK failed: " #cond ": " + fmt::format(__VA_ARGS__)); \
  } while (0)

#ifdef NDEBUG
#define DCHECK(cond) \
  do {               \
  } while (0)
#else
/// CHECK in debug builds only, for inner loops.
#define DCHECK(cond) CHECK(cond)
#endif

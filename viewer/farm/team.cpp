#include "viewer/farm/team.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace relume {
namespace {

constexpr int max_ranks = 1 << 20;

/// The variables of one launcher.
struct Launcher {
  const char* rank;
  const char* size;
  const char* local_size;  ///< or null
};

constexpr Launcher launchers[] = {
    {"RELUME_RANK", "RELUME_RANKS", "RELUME_LOCAL_RANKS"},
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_LOCAL_SIZE"},
    {"PMI_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"},
};

std::optional<int> number_of(const char* variable, int low, int high) {
  const char* const value = std::getenv(variable);
  if (value == nullptr) return std::nullopt;
  const std::string_view text = value;
  int number = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size() || number < low ||
      number > high) {
    throw Error(ErrorKind::usage, fmt::format("{}='{}': is not a number from {} to {}", variable,
                                              printable(text), low, high));
  }
  return number;
}

int saved_error_stream = -1;

void send_nowhere(std::FILE* stream) {
  std::fflush(stream);
  const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere < 0) return;
  dup2(nowhere, fileno(stream));
  close(nowhere);
}

}  // namespace

Team team_from_environment() {
  for (const Launcher& launcher : launchers) {
    const auto size = number_of(launcher.size, 1, max_ranks);
    if (!size) continue;
    const auto rank = number_of(launcher.rank, 0, *size - 1);
    if (!rank) continue;
    const auto local = number_of(launcher.local_size, 1, *size);
    return {*rank, *size, local.value_or(1)};
  }
  return {};
}

int share_of_processors(const Team& team) {
  const auto processors = static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
  return std::max(1, std::min(thread_count(), processors / std::max(1, team.local_size)));
}

void listen_only(const Team& team) {
  if (team.rank == 0) return;
  send_nowhere(stdout);
  saved_error_stream = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
  if (saved_error_stream >= 0) send_nowhere(stderr);
}

void speak() {
  if (saved_error_stream < 0) return;
  std::fflush(stderr);
  dup2(saved_error_stream, STDERR_FILENO);
  close(saved_error_stream);
  saved_error_stream = -1;
}

}  // namespace relume

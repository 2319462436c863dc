#include "viewer/commands/bench_caches.h"

#include <fmt/format.h>

#include <memory>

#include "viewer/commands/bench_time.h"
#include "viewer/commands/process_memory.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

void append_rows(std::span<const NamedCache> caches, int lights, int repeats,
                 std::vector<FigureRow>& rows) {
  std::vector<std::unique_ptr<RepeatedFrame>> frames;
  std::vector<std::function<void()>> moves;
  for (const NamedCache& named : caches) {
    frames.push_back(std::make_unique<RepeatedFrame>(*named.cache, lights));
    moves.emplace_back([frame = frames.back().get()] { frame->move_all(); });
  }
  const std::vector<double> ms = least_ms_in_turn(repeats, moves);
  double first_ns = 0;
  for (size_t i = 0; i < caches.size(); ++i) {
    const RelightCache& cache = *caches[i].cache;
    const uint64_t records = cache.info().record_count;
    const double ns = ms[i] * 1e6 / static_cast<double>(records) / lights;
    if (i == 0) first_ns = ns;
    rows.push_back(
        {{"name", caches[i].name + (lights > 1 ? fmt::format("-{}-lights", lights) : "")},
         {"ms", ms[i]},
         {"ratio", ms[i] / ms[0]},
         {"records", static_cast<int64_t>(records)},
         {"ns_per_record", ns},
         {"ns_per_record_ratio", ns / first_ns},
         {"bytes", static_cast<int64_t>(cache.size_bytes())}});
  }
}

}  // namespace

std::vector<FigureRow> bench_caches(std::span<const NamedCache> caches, int repeats) {
  std::vector<FigureRow> rows;
  for (const int lights : {1, 4}) append_rows(caches, lights, repeats, rows);
  return rows;
}

FigureRow memory_row(const NamedCache& named) {
  const auto before = static_cast<double>(allocated_bytes());
  const RepeatedFrame frame(*named.cache, 1);
  const double state = static_cast<double>(allocated_bytes()) - before;
  const auto cache = static_cast<double>(named.cache->size_bytes());
  return {{"name", "memory-" + named.name},
          {"cache_bytes", static_cast<int64_t>(cache)},
          {"state_bytes", static_cast<int64_t>(state)},
          {"working_over_cache", (cache + state) / cache},
          {"peak_bytes", static_cast<int64_t>(peak_memory_bytes())}};
}

}  // namespace relume

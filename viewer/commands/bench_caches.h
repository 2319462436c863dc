#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// A cache and what to call it.
struct NamedCache {
  std::string name;
  const RelightCache* cache;
};

/// Times frames of several caches in turn, in which one light moves and in which four do, least of
/// `repeats`: rows `<name>` and `<name>-4-lights` with ms, ratio (to the first cache), records,
/// ns_per_record (and light), ns_per_record_ratio and bytes.
std::vector<FigureRow> bench_caches(std::span<const NamedCache> caches, int repeats);

/// One row `memory-<name>`: cache_bytes; state_bytes, what a state of one light takes beside;
/// working_over_cache, their sum / cache_bytes; and peak_bytes of the process so far.
FigureRow memory_row(const NamedCache& cache);

}  // namespace relume

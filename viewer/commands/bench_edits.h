#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// Times what a user does to lights, against a frame in which the only light moves. All rows hold
/// ms and ratio (to that frame, timed in turn with it), least of `repeats`:
///   gain-16-layers   one of 16 lights is dimmed; gain-drag-16-layers: again and again
///   drag-of-<n>      one of n lights moves, n = 1, 16, 64, 256; state_bytes: memory of their state
///   first-frame-<n>  n lights into fresh memory, once
/// Rows whose layers would need more than 6 GiB are left out.
std::vector<FigureRow> bench_edits(const RelightCache& cache, int repeats);

}  // namespace relume

#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// Times what a user does to lights, against a frame in which the only light moves. All rows hold
/// ms and ratio (to that frame, timed in turn with it), least of `repeats`:
///   coarse-frame         the only light moves, a quarter of the pixels
///   gain-16-layers       one of 16 lights is dimmed
///   gain-drag-16-layers  the same, as one of a row of such frames (RelightParams::dragging)
///   drag-of-<n>          one of n lights is dragged, n = 1, 16, 64, 256; ratio to a drag of the
///                        only one; state_bytes: memory of their state
///   first-frame-<n>      n lights into fresh memory, once
/// Rows whose layers would need more than 6 GiB are left out.
std::vector<FigureRow> bench_edits(const RelightCache& cache, int repeats);

}  // namespace relume

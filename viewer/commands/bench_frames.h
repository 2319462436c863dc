#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/bench_machine.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// Times frames in which unshadowed lights of one kind move: the cache's first light, and four of
/// them in one pass, on every instruction set of this machine (`frame-<set>`,
/// `frame-<set>-4-lights`), and the plain double loop on one thread (`frame-double-1-thread` ...).
/// A frame is relight(): shading, layers and their sum. Least time of `repeats`, all threads:
///   ms, records_per_s (records x lights)
///   memory_floor_ms   reading the cache's bytes, measured in this process beforehand
///   write_floor_ms    reading them and writing layers and frame, the same
///   port_floor_ms     port-bound cycles of the kernels / clock / threads; null without `ports`
///   floor_ms, ratio   the larger of memory_floor_ms and port_floor_ms; ms / floor_ms
///   ratio_write       ms / the larger of write_floor_ms and port_floor_ms
///   hot_ms, hot_ratio the kernels alone on tiles that stay in the second-level cache, one thread,
///                     scaled to the frame and divided by the threads; ms / hot_ms
///   ms_1_thread, scaling   the frame on one thread; ms_1_thread / ms
///   double_ratio      the double loop's time under the same lights / ms_1_thread
/// The double rows hold ms alone.
std::vector<FigureRow> bench_frames(const RelightCache& cache, int repeats,
                                    const MemoryFloor& memory, const PortCycles& ports,
                                    int threads);

}  // namespace relume

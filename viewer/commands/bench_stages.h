#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "core/trace/tracer.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// What the preprocess is timed on.
struct BenchStagesParams {
  int spp = 25;                 ///< samples per pixel
  ReductionParams reduction;    ///< its method is not used: several are timed
  TrainingParams training;      ///< not used by Light-Fit
  int repeats = 5;              ///< of each stage, the least time counts; fewer of slow ones
  double most_reduce_ms = 2e4;  ///< a reduction that would take longer runs on fewer tiles
};

/// Times the preprocess of the picture that `info` describes, stage by stage, each with all
/// threads: `sample`, `reduce-<method>` for kmeans, strong-kmeans, light-fit-fast and light-fit,
/// `pack` and `write-cache` (a temporary file, flushed to the disk) of strong k-means' records. A
/// row holds
///   ms             of the whole picture, scaled up from the pixels that were measured;
///   pixels         measured: all, or tiles spread over the picture where the samples would fill
///                  the memory or a reduction would take longer than most_reduce_ms;
///   records_per_s  what comes out: records, samples from `sample`;
///   samples_per_s  of the same pixels;
///   bytes_per_record (write-cache).
/// Training lights are made beforehand and not counted. Throws Error(output) when the temporary
/// file cannot be written.
std::vector<FigureRow> bench_stages(const Scene& scene, const Tracer& tracer, const CacheInfo& info,
                                    const BenchStagesParams& params);

}  // namespace relume

#pragma once

#include <vector>

#include "core/samples/relight_cache.h"
#include "viewer/commands/json_output.h"

namespace relume {

/// Points (x, ms) and the straight line of least relative error through them.
struct LineFit {
  double intercept_ms = 0;
  double slope_ms = 0;
  double largest_deviation = 0;  ///< of the line from a point, relative to the point
};

/// ms > 0. Not a number where all x are the same.
LineFit fit_line(const std::vector<double>& x, const std::vector<double>& ms);

/// Times frames whose lights move over cuts of the cache (cut_cache) that hold at most some 8
/// million records, least of `repeats`, sizes in turn:
///   records-<k>    one light, k = 1, 2, 4, 8, 16 records in every covered pixel
///   pixels-<size>  one light, the cache's average k everywhere, the upper quarter, half and all
///   rows lights-<n>     n = 1, 2, 4, 8, 16 lights move
/// each with x (records a covered pixel, covered pixels, lights), ms, fit_ms and the fit's relative
/// deviation; after each group linear-<what> with the line and its largest deviation. Then
/// frame-cost: FrameCost is given two thirds of these frames and of frames with a light dimmed, and
/// predicts the others: predicted / actual, least and largest, and each.
std::vector<FigureRow> bench_linearity(const RelightCache& cache, int repeats);

}  // namespace relume

#pragma once

#include <array>

#include "core/base/label.h"
#include "core/samples/sample_tile.h"

namespace relume {

/// How a pixel's samples become its records.
enum class ReductionMethod {
  all,            ///< every sample is a record: the reference
  pure,           ///< no reduction: the sampler takes k fresh stratified samples (TR2007-600 sec. 4.2)
  kmeans,         ///< the report's K-means, sec. 3.1, on raw fields from the first k samples
  strong_kmeans,  ///< k-means++ with restarts on scaled fields, at least one record a type
};

inline constexpr std::array reduction_method_labels = {
    Label<ReductionMethod>{ReductionMethod::all, "all"},
    Label<ReductionMethod>{ReductionMethod::pure, "pure"},
    Label<ReductionMethod>{ReductionMethod::kmeans, "kmeans"},
    Label<ReductionMethod>{ReductionMethod::strong_kmeans, "strong-kmeans"},
};

struct ReductionParams {
  ReductionMethod method = ReductionMethod::strong_kmeans;
  int records = 8;           ///< k, at most, per pixel: 1..64
  int max_iterations = 100;  ///< of k-means, per run
  int restarts = 4;          ///< strong k-means: k-means++ starts, best inertia wins
  uint64_t seed = 0;
  float scene_radius = 1;    ///< world; the unit of positions in scaled features
};

/// Reduces every pixel of a tile. `samples` and the result share the types' order; the weights of a
/// pixel sum to the same coverage. Deterministic in (samples, params, absolute pixel position); no
/// thread or neighbour changes a pixel. `image_width` turns a position into the pixel's number.
SampleTile reduce_tile(const SampleTile& samples, std::span<const SampleType> types,
                       const ReductionParams& params, int image_width);

}  // namespace relume

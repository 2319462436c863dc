#pragma once

#include <array>

#include "core/base/label.h"
#include "core/samples/sample_tile.h"

namespace relume {

/// How a pixel's samples become its records.
enum class ReductionMethod {
  all,     ///< every sample is a record: the reference
  pure,    ///< no reduction: the sampler takes k fresh stratified samples (TR2007-600 sec. 4.2)
  kmeans,  ///< the report's K-means, sec. 3.1, on raw fields from the first k samples
  strong_kmeans,   ///< k-means++ with restarts on scaled fields, keeps rare types
  kmedoids,        ///< partitioning around medoids on scaled fields, keeps rare types
  cmeans,          ///< fuzzy C-means (the report's sec. 5) on scaled fields, keeps rare types
  light_metric_1,  ///< the samples closest to the pixel under the training lights, sec. 3.2, eq. 4
  light_metric_2,  ///< the same, drawn from shader groups, sec. 3.3, eq. 5
  light_metric_3,  ///< the same, with the most typical white-Lambert member of each cluster,
                   ///< sec. 3.4
  light_metric_4,  ///< the samples whose running mean is closest to the pixel, sec. 3.5, eq. 6
  light_metric_5,  ///< k-means on the samples' values under the training lights, sec. 3.6
  light_metric_6,  ///< k-means' clusters with the representatives of eq. 4, sec. 3.7
  light_fit_fast,  ///< ours: one record fitted to each cluster of responses
  light_fit,       ///< the same, then all records of the pixel polished together on eq. 2
};

inline constexpr std::array reduction_method_labels = {
    Label<ReductionMethod>{ReductionMethod::all, "all"},
    Label<ReductionMethod>{ReductionMethod::pure, "pure"},
    Label<ReductionMethod>{ReductionMethod::kmeans, "kmeans"},
    Label<ReductionMethod>{ReductionMethod::strong_kmeans, "strong-kmeans"},
    Label<ReductionMethod>{ReductionMethod::kmedoids, "kmedoids"},
    Label<ReductionMethod>{ReductionMethod::cmeans, "cmeans"},
    Label<ReductionMethod>{ReductionMethod::light_metric_1, "light-metric-1"},
    Label<ReductionMethod>{ReductionMethod::light_metric_2, "light-metric-2"},
    Label<ReductionMethod>{ReductionMethod::light_metric_3, "light-metric-3"},
    Label<ReductionMethod>{ReductionMethod::light_metric_4, "light-metric-4"},
    Label<ReductionMethod>{ReductionMethod::light_metric_5, "light-metric-5"},
    Label<ReductionMethod>{ReductionMethod::light_metric_6, "light-metric-6"},
    Label<ReductionMethod>{ReductionMethod::light_fit_fast, "light-fit-fast"},
    Label<ReductionMethod>{ReductionMethod::light_fit, "light-fit"},
};

/// True for methods that look at samples under training lights: reduce_tile needs a TrainingSet.
bool needs_training(ReductionMethod method);

/// True for Light-Fit, whose training lights are spread evenly (make_mixed_training_lights).
bool is_light_fit(ReductionMethod method);

/// True for the methods that TR2007-600 measures: PURE, K-means and Light Metric 1 to 6.
bool is_report_method(ReductionMethod method);

/// Named sets of choices for everything but method, k and spp.
enum class ReductionPreset {
  standard,         ///< the defaults: light metrics are trained without shadows
  report_faithful,  ///< TR2007-600 to the letter; only for its own methods
};

inline constexpr std::array reduction_preset_labels = {
    Label<ReductionPreset>{ReductionPreset::standard, "standard"},
    Label<ReductionPreset>{ReductionPreset::report_faithful, "report-faithful"},
};

struct ReductionParams {
  ReductionMethod method = ReductionMethod::strong_kmeans;
  int records = 8;           ///< k, at most, per pixel: 1..64
  int max_iterations = 100;  ///< of k-means, per run
  int restarts = 4;          ///< strong k-means, C-means: k-means++ starts, best inertia wins
  uint64_t seed = 0;
  float scene_radius = 1;  ///< world; the unit of positions in scaled features
  /// > 0: every pixel takes the k up to `records` of least predicted error + record_cost * k; see
  /// solve_record_cost. 0: k = `records` everywhere. In units of the picture.
  float record_cost = 0;
  int stored_members = 0;      ///< positions a record keeps of its members, 0..max_members
  bool predict_error = false;  ///< fill SampleTile::predicted_error whatever the method
};

/// True when validation lights are asked for: by Light-Fit, a budget, or predict_error.
bool needs_validation(const ReductionParams& params);

/// The report's own choices for one of its methods, those of its experiment 1 (sec. 4.2): k = 8,
/// raw units, the first k samples as seeds, types may be lost. Its lights:
/// report_faithful_training().
ReductionParams report_faithful_params(ReductionMethod method);

struct TrainingSet;

/// The lights that a reduction looks at, made for the same types. Not owned.
struct ReductionLights {
  const TrainingSet* training = nullptr;    ///< for methods that need training
  const TrainingSet* validation = nullptr;  ///< others, to judge what was fitted to those
};

/// Reduces every pixel of a tile. `samples` and the result share the types' order; the weights of a
/// pixel sum to the same coverage, unless the budget leaves it without records. Deterministic in
/// (samples, params, lights, absolute pixel position); no thread or neighbour changes a pixel.
/// `image_width` turns a position into the pixel's number. Fills predicted_error where validation
/// lights are needed anyway. Thread-safe.
SampleTile reduce_tile(const SampleTile& samples, std::span<const SampleType> types,
                       const ReductionParams& params, int image_width,
                       const ReductionLights& lights = {});

}  // namespace relume

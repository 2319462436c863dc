#include "reduction/reduction.h"

#include "core/base/check.h"
#include "reduction/pixel_reducer.h"

namespace relume {

bool needs_training(ReductionMethod method) {
  switch (method) {
    case ReductionMethod::all:
    case ReductionMethod::pure:
    case ReductionMethod::kmeans:
    case ReductionMethod::strong_kmeans:
    case ReductionMethod::kmedoids:
    case ReductionMethod::cmeans:
      return false;
    case ReductionMethod::light_metric_1:
    case ReductionMethod::light_metric_2:
    case ReductionMethod::light_metric_3:
    case ReductionMethod::light_metric_4:
    case ReductionMethod::light_metric_5:
    case ReductionMethod::light_metric_6:
    case ReductionMethod::light_fit_fast:
    case ReductionMethod::light_fit:
      return true;
  }
  return false;
}

bool is_light_fit(ReductionMethod method) {
  return method == ReductionMethod::light_fit_fast || method == ReductionMethod::light_fit;
}

bool needs_validation(const ReductionParams& params) {
  return is_light_fit(params.method) || params.record_cost > 0 || params.predict_error;
}

bool is_report_method(ReductionMethod method) {
  switch (method) {
    case ReductionMethod::all:
    case ReductionMethod::strong_kmeans:
    case ReductionMethod::kmedoids:
    case ReductionMethod::cmeans:
    case ReductionMethod::light_fit_fast:
    case ReductionMethod::light_fit:
      return false;
    case ReductionMethod::pure:
    case ReductionMethod::kmeans:
    case ReductionMethod::light_metric_1:
    case ReductionMethod::light_metric_2:
    case ReductionMethod::light_metric_3:
    case ReductionMethod::light_metric_4:
    case ReductionMethod::light_metric_5:
    case ReductionMethod::light_metric_6:
      return true;
  }
  return false;
}

ReductionParams report_faithful_params(ReductionMethod method) {
  CHECK_MSG(is_report_method(method), "method {}", static_cast<int>(method));
  ReductionParams params;
  params.method = method;
  params.records = 8;
  params.max_iterations = 100;
  return params;
}

SampleTile reduce_tile(const SampleTile& samples, std::span<const SampleType> types,
                       const ReductionParams& params, int image_width,
                       const ReductionLights& lights) {
  if (params.method == ReductionMethod::all || params.method == ReductionMethod::pure) {
    return samples;
  }
  SampleTile result;
  result.x0 = samples.x0;
  result.y0 = samples.y0;
  result.width = samples.width;
  result.height = samples.height;
  result.types.resize(types.size());
  result.emission = samples.emission;
  result.has_footprints = true;
  result.has_members = params.stored_members > 0;
  for (TypedRows& rows : result.types) rows.first.push_back(0);
  PixelReducer reducer(types, params, lights);
  PixelRecords records;
  for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    const int x = samples.x0 + pixel % samples.width;
    const int y = samples.y0 + pixel / samples.width;
    reducer.load(samples, pixel, static_cast<uint64_t>(y) * static_cast<uint64_t>(image_width) + x);
    const bool budget = params.record_cost > 0;
    const float error =
        budget ? reducer.reduce_within_cost(records) : reducer.reduce(params.records, records);
    if (needs_validation(params)) result.predicted_error.push_back(error);
    if (budget) result.coverage.push_back(reducer.coverage());
    for (size_t t = 0; t < types.size(); ++t) {
      TypedRows& rows = result.types[t];
      rows.values.insert(rows.values.end(), records[t].values.begin(), records[t].values.end());
      rows.weights.insert(rows.weights.end(), records[t].weights.begin(), records[t].weights.end());
      rows.footprints.insert(rows.footprints.end(), records[t].footprints.begin(),
                             records[t].footprints.end());
      rows.members.insert(rows.members.end(), records[t].members.begin(), records[t].members.end());
      rows.first.push_back(static_cast<uint32_t>(rows.rows()));
    }
  }
  return result;
}

}  // namespace relume

#include "reduction/pixel_reducer.h"

#include <limits>
#include <numeric>

#include "core/base/check.h"
#include "reduction/allocation.h"
#include "reduction/footprints.h"
#include "reduction/merge.h"
#include "reduction/methods/cmeans.h"
#include "reduction/methods/kmeans.h"
#include "reduction/methods/kmedoids.h"

namespace relume {
namespace {

LightFitParams fit_params(const ReductionParams& params) {
  LightFitParams fit;
  fit.joint = params.method == ReductionMethod::light_fit;
  return fit;
}

void clear(TypedRows& rows) {
  rows.values.clear();
  rows.weights.clear();
  rows.footprints.clear();
  rows.members.clear();
}

void clear(PixelRecords& records, size_t types) {
  records.resize(types);
  for (TypedRows& rows : records) clear(rows);
}

int row_count(const PixelRecords& records) {
  size_t count = 0;
  for (const TypedRows& rows : records) count += rows.rows();
  return static_cast<int>(count);
}

}  // namespace

PixelReducer::PixelReducer(std::span<const SampleType> types, const ReductionParams& params,
                           const ReductionLights& lights)
    : types_(types), params_(params), lights_(lights) {
  CHECK_MSG(params.method != ReductionMethod::all && params.method != ReductionMethod::pure,
            "method {} does not reduce", label_of(reduction_method_labels, params.method));
  CHECK_MSG(params.records >= 1, "records {}", params.records);
  CHECK_MSG(!needs_training(params.method) || lights.training != nullptr,
            "method {} needs training", label_of(reduction_method_labels, params.method));
  CHECK_MSG(!needs_validation(params) || lights.validation != nullptr,
            "method {} needs validation lights", label_of(reduction_method_labels, params.method));
  if (is_light_fit(params.method)) {
    light_fit_.emplace(lights.training->evaluator, fit_params(params));
  } else if (needs_training(params.method)) {
    light_metric_.emplace(*lights.training);
  }
}

void PixelReducer::load(const SampleTile& tile, int index, uint64_t pixel) {
  pixel_ = pixel;
  matrices_.clear();
  counts_.clear();
  double weight = 0;
  for (size_t t = 0; t < types_.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const uint32_t first = rows.first[index];
    const uint32_t last = rows.first[index + 1];
    matrices_.push_back({&types_[t], rows.values.data() + size_t{first} * types_[t].width,
                         static_cast<int>(last - first)});
    counts_.push_back(matrices_.back().rows);
    for (uint32_t row = first; row < last; ++row) weight += rows.weights[row];
  }
  sample_count_ = std::accumulate(counts_.begin(), counts_.end(), 0);
  coverage_ = static_cast<float>(weight);
  trained_ = false;
  target_ready_ = false;
}

/// The pixel's own random numbers for one type; strong k-means and its kin share type 0's.
Random PixelReducer::make_random(size_t type) const {
  return Random(params_.seed, RandomStream::reduction, pixel_ + (uint64_t{type} << 40));
}

void PixelReducer::train() {
  if (trained_) return;
  trained_ = true;
  const float weight = coverage_ / static_cast<float>(sample_count_);
  if (light_metric_) light_metric_->prepare(params_.method, matrices_, weight);
  if (light_fit_) fit_applies_ = light_fit_->load(matrices_, weight);
}

float PixelReducer::reduce(int k, PixelRecords& records) {
  CHECK_MSG(k >= 1, "k {}", k);
  clear(records, types_.size());
  if (sample_count_ == 0) return 0;
  const std::vector<int> allocation =
      allocate_records(counts_, k, !is_report_method(params_.method));
  // Eq. 3: a record weighs members / members of all clusters. Types without a record are lost and
  // the others grow to fill the pixel's coverage.
  int clustered = 0;
  for (size_t t = 0; t < counts_.size(); ++t) clustered += allocation[t] > 0 ? counts_[t] : 0;
  const float weight = coverage_ / static_cast<float>(clustered);
  if (allocation != counts_) train();
  Random random = make_random(0);
  for (size_t t = 0; t < counts_.size(); ++t) {
    if (allocation[t] == 0) continue;
    if (allocation[t] == counts_[t]) {
      copy_rows(matrices_[t], weight, records[t]);
    } else {
      reduce_type(t, allocation[t], weight, random, records[t]);
    }
  }
  if (allocation == counts_ || !needs_validation(params_)) return 0;
  const float error = predicted_error(records);
  return light_fit_ && fit_applies_ ? fit(allocation, records, error) : error;
}

void PixelReducer::reduce_type(size_t type, int k, float weight, Random& random,
                               TypedRows& records) {
  const SampleMatrix& samples = matrices_[type];
  if (light_metric_) {
    Random draws = make_random(type);
    merge_clusters(samples, light_metric_->cluster(static_cast<int>(type), k, params_, draws),
                   weight, records, params_.stored_members);
    return;
  }
  if (params_.method == ReductionMethod::kmeans) {
    make_raw_features(samples, features_);
    first_k_.resize(k);
    std::iota(first_k_.begin(), first_k_.end(), 0);
    merge_clusters(samples, kmeans(features_, first_k_, params_.max_iterations), weight, records,
                   params_.stored_members);
    return;
  }
  make_scaled_features(samples, params_.scene_radius, features_);
  switch (params_.method) {
    case ReductionMethod::strong_kmeans:
    case ReductionMethod::light_fit_fast:
    case ReductionMethod::light_fit:
      merge_clusters(
          samples,
          strong_kmeans(features_, k, params_.restarts, params_.max_iterations, random, kmeans_),
          weight, records, params_.stored_members);
      return;
    case ReductionMethod::kmedoids:
      merge_clusters(samples, kmedoids(features_, k, params_.max_iterations), weight, records,
                     params_.stored_members);
      return;
    case ReductionMethod::cmeans:
      merge_fuzzy_clusters(samples,
                           cmeans(features_, k, params_.restarts, params_.max_iterations, random),
                           weight, records, params_.stored_members);
      return;
    default:
      CHECK_MSG(false, "method {}", static_cast<int>(params_.method));
  }
}

float PixelReducer::fit(const std::vector<int>& allocation, PixelRecords& records, float error) {
  // Types that cannot be fitted keep the records they have; the fit shares out the others.
  int k = 0;
  int clustered = 0;
  int represented = 0;
  for (size_t t = 0; t < allocation.size(); ++t) {
    const bool is_fitted = light_fit_->fits_type(static_cast<int>(t));
    if (is_fitted) k += allocation[t];
    if (allocation[t] > 0) clustered += counts_[t];
    if (is_fitted || allocation[t] > 0) represented += counts_[t];
  }
  if (k < 1 || k >= light_fit_->sample_count()) return error;
  const std::vector<FittedRecord> fitted = light_fit_->fit(k);
  if (fitted.empty()) return error;
  trial_ = records;
  // Eq. 3 again: fewer types are lost than when each is clustered alone.
  const float kept_scale = static_cast<float>(clustered) / static_cast<float>(represented);
  const float fitted_scale = static_cast<float>(sample_count_) / static_cast<float>(represented);
  for (size_t t = 0; t < trial_.size(); ++t) {
    for (float& weight : trial_[t].weights) weight *= kept_scale;
    if (!light_fit_->fits_type(static_cast<int>(t))) continue;
    clear(trial_[t]);
  }
  for (const FittedRecord& record : fitted) {
    TypedRows& rows = trial_[record.type];
    rows.values.insert(rows.values.end(), record.vector.begin(), record.vector.end());
    rows.weights.push_back(record.weight * fitted_scale);
    append_footprint(record.members, {record.vector[0], record.vector[1], record.vector[2]},
                     params_.stored_members, rows);
  }
  const float fitted_error = predicted_error(trial_);
  if (!(fitted_error < error)) return error;
  std::swap(records, trial_);
  return fitted_error;
}

void PixelReducer::add_values(const SampleType& type, int type_index, const float* vectors,
                              const float* weights, size_t rows, std::vector<float>& sum) {
  const LobeEvaluator& evaluator = lights_.validation->evaluator;
  const auto columns = static_cast<size_t>(evaluator.lights().columns());
  lobes_.resize(max_lobes * columns);
  values_.resize(3 * columns);
  for (size_t row = 0; row < rows; ++row) {
    const float* vector = vectors + row * type.width;
    evaluator.lobes(type_index, vector, lobes_.data());
    shade_rows(evaluator, type_index, vector, 1, lobes_.data(), values_.data());
    for (size_t i = 0; i < values_.size(); ++i) sum[i] += weights[row] * values_[i];
  }
}

const std::vector<float>& PixelReducer::target() {
  if (target_ready_) return target_;
  target_ready_ = true;
  const auto length = size_t{3} * lights_.validation->evaluator.lights().columns();
  target_.assign(length, 0.0f);
  const float weight = coverage_ / static_cast<float>(std::max(1, sample_count_));
  for (size_t t = 0; t < matrices_.size(); ++t) {
    weights_.assign(matrices_[t].rows, weight);
    add_values(types_[t], static_cast<int>(t), matrices_[t].values, weights_.data(),
               weights_.size(), target_);
  }
  return target_;
}

float PixelReducer::predicted_error(const PixelRecords& records) {
  const std::vector<float>& expected = target();
  sum_.assign(expected.size(), 0.0f);
  for (size_t t = 0; t < records.size(); ++t) {
    add_values(types_[t], static_cast<int>(t), records[t].values.data(), records[t].weights.data(),
               records[t].rows(), sum_);
  }
  const size_t columns = expected.size() / 3;
  double error = 0;
  for (size_t j = 0; j < columns; ++j) {
    double squares = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double d = double{sum_[c * columns + j]} - expected[c * columns + j];
      squares += d * d;
    }
    error += std::sqrt(squares / 3);
  }
  error /= std::max(1, lights_.validation->lights->light_count);
  // Values beyond a float's range are as wrong as can be; nothing non-finite is passed on.
  constexpr double largest = std::numeric_limits<float>::max();
  return static_cast<float>(error < largest ? error : largest);
}

ErrorCurve PixelReducer::error_curve(float cost) {
  ErrorCurve curve;
  try_steps(cost, curve, nullptr);
  return curve;
}

float PixelReducer::reduce_within_cost(PixelRecords& records) {
  ErrorCurve curve;
  try_steps(params_.record_cost, curve, &records);
  return curve.errors[choose_step(curve, params_.record_cost)];
}

void PixelReducer::try_steps(float cost, ErrorCurve& curve, PixelRecords* best) {
  PixelRecords records;
  clear(records, types_.size());
  const std::vector<float>& values = target();
  double sum = 0;
  for (const float value : values) sum += value;
  const int lights = std::max(1, lights_.validation->lights->light_count);
  curve.value = static_cast<float>(std::min(sum / (3.0 * lights), 1e38));
  const auto add = [&](float error) {
    curve.errors.push_back(error);
    curve.records.push_back(row_count(records));
    if (best != nullptr && choose_step(curve, cost) + 1 == curve.errors.size()) *best = records;
  };
  add(predicted_error(records));
  const int most = std::min(params_.records, sample_count_);
  for (size_t i = 1; i < record_steps.size() && record_steps[i - 1] < most; ++i) {
    const int k = std::min(record_steps[i], most);
    const size_t chosen = choose_step(curve, cost);
    // An error is at least 0: more records cannot pay once they alone cost more than the best step
    // does in all.
    const double least = curve.errors[chosen] + double{cost} * curve.records[chosen];
    if (double{cost} * k >= least) break;
    add(reduce(k, records));
  }
}

}  // namespace relume

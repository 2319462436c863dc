#include "reduction/methods/light_metric.h"

#include <numeric>

#include "core/base/check.h"
#include "reduction/methods/kmeans.h"

namespace relume {
namespace {

RareEvent clamped_responses("training responses above 1e30, clamped");

constexpr float max_response = 1e30f;

/// The largest value; values beyond max_response, not-a-number included, are set to it.
float clamp_and_find_max(std::vector<float>& values) {
  float most = 0;
  for (float& value : values) {
    value = value < max_response ? value : max_response;
    most = most < value ? value : most;
  }
  return most;
}

std::vector<int> first_rows(int k) {
  std::vector<int> rows(k);
  std::iota(rows.begin(), rows.end(), 0);
  return rows;
}

}  // namespace

void LightMetric::prepare(ReductionMethod method, std::span<const SampleMatrix> matrices,
                          float weight_per_sample) {
  method_ = method;
  matrices_.assign(matrices.begin(), matrices.end());
  evaluate_training(training_, matrices, weight_per_sample, responses_);
  float most = 0;
  for (std::vector<float>& v : responses_.v) most = std::max(most, clamp_and_find_max(v));
  if (method == ReductionMethod::light_metric_2 || method == ReductionMethod::light_metric_3) {
    find_mean_colors();
  }
  if (method == ReductionMethod::light_metric_3) find_white_values(weight_per_sample);
  // Eqs. 4 and 6 only compare: relative to the largest value their squares stay within a float.
  const float scale = most > 0 ? 1.0f / most : 1.0f;
  for (std::vector<float>& v : responses_.v) {
    for (float& value : v) value *= scale;
  }
  if (most < max_response) {
    for (float& value : responses_.target) value *= scale;
  } else {
    clamped_responses.add();
    sum_target(matrices, weight_per_sample, responses_);
  }
}

ValueRows LightMetric::rows(int type) const {
  return {responses_.v[type].data(), matrices_[type].rows, 3 * responses_.columns};
}

void LightMetric::find_mean_colors() {
  const int columns = responses_.columns;
  mean_colors_.resize(matrices_.size());
  for (size_t t = 0; t < matrices_.size(); ++t) {
    mean_colors_[t].assign(matrices_[t].rows, vec3(0));
    for (int row = 0; row < matrices_[t].rows; ++row) {
      const float* values = rows(static_cast<int>(t)).row(row);
      for (size_t c = 0; c < 3; ++c) {
        const float* channel = values + c * columns;
        const double sum = std::accumulate(channel, channel + columns, 0.0);
        mean_colors_[t][row][c] = static_cast<float>(sum / training_.lights->light_count);
      }
    }
  }
}

void LightMetric::find_white_values(float weight_per_sample) {
  const int columns = responses_.columns;
  const auto& weights = training_.lights->weights;
  // A white sample is as bright in each channel as the light: one value a light, scaled by the norm
  // of the light's colour, has the same squares.
  std::vector<float> norms(columns);
  for (int j = 0; j < columns; ++j) {
    norms[j] = static_cast<float>(glm::length(dvec3(weights[0][j], weights[1][j], weights[2][j])));
  }
  white_.resize(matrices_.size());
  float most = 0;
  for (size_t t = 0; t < matrices_.size(); ++t) {
    white_[t].resize(static_cast<size_t>(matrices_[t].rows) * columns);
    for (int row = 0; row < matrices_[t].rows; ++row) {
      const float* lobe = &responses_.lobes[t][static_cast<size_t>(row) * max_lobes * columns];
      float* out = &white_[t][static_cast<size_t>(row) * columns];
      for (int j = 0; j < columns; ++j) out[j] = lobe[j] * norms[j];
    }
    most = std::max(most, clamp_and_find_max(white_[t]));
  }
  const float scale = most > 0 ? 1.0f / most : 1.0f;
  white_target_.assign(columns, 0.0f);
  for (size_t t = 0; t < matrices_.size(); ++t) {
    for (size_t i = 0; i < white_[t].size(); ++i) {
      white_[t][i] *= scale;
      white_target_[i % columns] += weight_per_sample * white_[t][i];
    }
  }
}

Clustering LightMetric::cluster_around(int type, std::span<const int> representatives) {
  make_raw_features(matrices_[type], features_);
  return assign_to_representatives(features_, representatives);
}

Clustering LightMetric::cluster_by_groups(int type, int k, Random& random) {
  eval_errors(rows(type), responses_.target.data(), errors_);
  const std::vector<int> groups = make_shader_groups(mean_colors_[type]);
  return cluster_around(type, draw_from_groups(groups, errors_, k, random));
}

Clustering LightMetric::cluster(int type, int k, const ReductionParams& params, Random& random) {
  const ValueRows v = rows(type);
  const float* target = responses_.target.data();
  CHECK_MSG(k >= 1 && k < v.rows, "k {} rows {}", k, v.rows);
  switch (method_) {
    case ReductionMethod::light_metric_1:
      eval_errors(v, target, errors_);
      return cluster_around(type, closest_rows(errors_, k));
    case ReductionMethod::light_metric_2:
      return cluster_by_groups(type, k, random);
    case ReductionMethod::light_metric_3: {
      Clustering clustering = cluster_by_groups(type, k, random);
      eval_errors({white_[type].data(), v.rows, responses_.columns}, white_target_.data(), errors_);
      choose_representatives(errors_, clustering);
      return clustering;
    }
    case ReductionMethod::light_metric_4:
      return cluster_around(type, greedy_rows(v, target, k));
    case ReductionMethod::light_metric_5:
      features_.rows = v.rows;
      features_.dimensions = v.length;
      features_.values.assign(v.values, v.row(v.rows));
      return kmeans(features_, first_rows(k), params.max_iterations);
    case ReductionMethod::light_metric_6: {
      make_raw_features(matrices_[type], features_);
      Clustering clustering = kmeans(features_, first_rows(k), params.max_iterations);
      eval_errors(v, target, errors_);
      choose_representatives(errors_, clustering);
      return clustering;
    }
    default:
      break;
  }
  CHECK_MSG(false, "method {}", static_cast<int>(method_));
  return {};
}

}  // namespace relume

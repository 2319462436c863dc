#include "reduction/methods/light_fit_pixel.h"

#include <algorithm>

#include "core/simd/dot_products.h"

namespace relume {
namespace {

constexpr size_t shape_width = 16;  ///< position and direction, padded for dot_products

dvec3 position_of(const FitSample& sample) {
  return {sample.vector[0], sample.vector[1], sample.vector[2]};
}

}  // namespace

bool FitPixel::load(std::span<const SampleMatrix> matrices, float weight_per_sample,
                    const std::vector<bool>& is_fitted) {
  weight = weight_per_sample;
  samples.clear();
  fitted_.assign(matrices.begin(), matrices.end());
  int count = 0;
  for (size_t t = 0; t < fitted_.size(); ++t) {
    if (!is_fitted[t]) fitted_[t].rows = 0;
    count += fitted_[t].rows;
  }
  if (count == 0) return false;
  evaluate_responses(evaluator, fitted_, weight, responses_);
  columns = responses_.columns;
  if (!find_scale()) return false;
  make_responses(fitted_, is_fitted);
  return true;
}

/// The factor of each column: the light's mean weight, over the size of the pixel's response.
bool FitPixel::find_scale() {
  double squares = 0;
  for (const float value : responses_.target) squares += double{value} * value;
  if (!(squares > 0) || !std::isfinite(squares)) return false;
  const double norm = 1 / std::sqrt(squares);
  const LightSet& lights = evaluator.lights();
  scale.clear();
  for (int j = 0; j < columns; ++j) {
    const double light =
        (double{lights.weights[0][j]} + lights.weights[1][j] + lights.weights[2][j]) / 3;
    scale.push_back(static_cast<float>(light * norm));
    if (!is_finite(scale.back())) return false;
  }
  return true;
}

/// Scales lobes and computes the responses to white lights from them.
void FitPixel::make_responses(std::span<const SampleMatrix> matrices,
                              const std::vector<bool>& is_fitted) {
  const auto width = static_cast<size_t>(columns);
  size_t n = 0;
  for (const SampleMatrix& matrix : matrices) n += static_cast<size_t>(matrix.rows);
  lobes_.assign(n * max_lobes * width, 0.0f);
  v_.assign(n * 3 * width, 0.0f);
  for (size_t t = 0; t < matrices.size(); ++t) {
    if (!is_fitted[t]) continue;
    const int type = static_cast<int>(t);
    for (int row = 0; row < matrices[t].rows; ++row) {
      const size_t i = samples.size();
      const float* vector = matrices[t].row(row);
      float* lobes = &lobes_[i * max_lobes * width];
      float* v = &v_[i * 3 * width];
      for (int k = 0; k < evaluator.lobe_count(type); ++k) {
        const float* source =
            &responses_.lobes[t][(static_cast<size_t>(row) * max_lobes + k) * width];
        float* lobe = lobes + k * width;
        for (size_t j = 0; j < width; ++j) lobe[j] = source[j] * scale[j];
        for (int c = 0; c < 3; ++c) {
          const float color = vector[evaluator.color_offset(type, k) + c];
          for (size_t j = 0; j < width; ++j) v[c * width + j] += color * lobe[j];
        }
      }
      samples.push_back({type, vector, v, lobes});
    }
  }
}

/// Position about the pixel's mean over their spread, and direction: 6 numbers a sample.
void FitPixel::make_shape_features() {
  shape_.assign(samples.size() * shape_width, 0.0f);
  dvec3 mean(0);
  for (const FitSample& s : samples) mean += position_of(s);
  mean /= n();
  double spread = 0;
  for (const FitSample& s : samples) {
    const dvec3 d = position_of(s) - mean;
    spread += glm::dot(d, d);
  }
  const double inverse_spread = spread > 0 ? std::sqrt(n() / spread) : 0;
  const FitSample& first = samples.front();
  const float* reference = first.vector + evaluator.direction_offset(first.type);
  for (size_t i = 0; i < samples.size(); ++i) {
    const FitSample& s = samples[i];
    float* out = &shape_[i * shape_width];
    for (int axis = 0; axis < 3; ++axis) {
      out[axis] = static_cast<float>((s.vector[axis] - mean[axis]) * inverse_spread);
    }
    const float* direction = s.vector + evaluator.direction_offset(s.type);
    const float side =
        direction[0] * reference[0] + direction[1] * reference[1] + direction[2] * reference[2];
    // Strand tangents have no sign.
    const float sign = evaluator.is_axis(s.type) && side < 0 ? -1.0f : 1.0f;
    for (int axis = 0; axis < 3; ++axis) out[3 + axis] = sign * direction[axis];
  }
}

void FitPixel::make_kernel(float position_weight) {
  const size_t size = samples.size() * samples.size();
  const int stride = static_cast<int>(length());
  kernel.resize(size);
  std::vector<float> shape(size);
  dot_products(v_.data(), n(), stride, v_.data(), n(), stride, stride, kernel.data(), n());
  make_shape_features();
  dot_products(shape_.data(), n(), shape_width, shape_.data(), n(), shape_width, shape_width,
               shape.data(), n());
  float response_trace = 0;
  float shape_trace = 0;
  for (size_t i = 0; i < samples.size(); ++i) {
    response_trace += kernel[i * samples.size() + i];
    shape_trace += shape[i * samples.size() + i];
  }
  const float a = response_trace > 0 ? 1 / response_trace : 0;
  const float b = shape_trace > 0 ? position_weight / shape_trace : 0;
  for (size_t i = 0; i < size; ++i) kernel[i] = a * kernel[i] + b * shape[i];
}

}  // namespace relume

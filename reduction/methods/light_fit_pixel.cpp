#include "reduction/methods/light_fit_pixel.h"

#include <algorithm>

#include "core/simd/dot_products.h"

namespace relume {
namespace {

/// Products of the two lobes of a record with each other.
struct TwoLobes {
  float a;  ///< first with first
  float b;  ///< first with second
  float d;  ///< second with second
};

/// The squared length of the best approximation, with colours x, y >= 0, of a response whose
/// products with the lobes are r0 and r1.
float explained(const TwoLobes& lobes, float r0, float r1) {
  const float first = lobes.a > 0 && r0 > 0 ? r0 * r0 / lobes.a : 0;
  const float second = lobes.d > 0 && r1 > 0 ? r1 * r1 / lobes.d : 0;
  const float determinant = lobes.a * lobes.d - lobes.b * lobes.b;
  if (determinant > 1e-4f * lobes.a * lobes.d) {
    const float x = lobes.d * r0 - lobes.b * r1;
    const float y = lobes.a * r1 - lobes.b * r0;
    if (x >= 0 && y >= 0) return (x * r0 + y * r1) / determinant;
  }
  return std::max(first, second);
}

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

std::vector<float> FitPixel::unexplained(float position_weight) const {
  const auto n_samples = static_cast<size_t>(n());
  const size_t n_lobes = n_samples * max_lobes;
  std::vector<float> gram(n_lobes * n_lobes);
  dot_products(lobes_.data(), static_cast<int>(n_lobes), columns, lobes_.data(),
               static_cast<int>(n_lobes), columns, columns, gram.data(), static_cast<int>(n_lobes));
  dvec3 mean(0);
  for (const FitSample& s : samples) mean += position_of(s);
  mean /= n();
  double spread = 0;
  for (const FitSample& s : samples) {
    const dvec3 d = position_of(s) - mean;
    spread += glm::dot(d, d);
  }
  const double per_square = spread > 0 ? double{position_weight} * n() / (2 * spread) : 0;
  std::vector<float> costs(n_samples * n_samples, 0.0f);
  for (size_t i = 0; i < n_samples; ++i) {
    const FitSample& sample = samples[i];
    const int lobe_count = evaluator.lobe_count(sample.type);
    float energy[3];
    float total = 0;
    const auto color = [&](int lobe, size_t c) {
      return lobe < lobe_count ? sample.vector[evaluator.color_offset(sample.type, lobe) + c]
                               : 0.0f;
    };
    const auto product = [&](size_t m, int a, int b) {
      return gram[(m * max_lobes + a) * n_lobes + i * max_lobes + b];
    };
    for (size_t c = 0; c < 3; ++c) {
      energy[c] = color(0, c) * color(0, c) * product(i, 0, 0) +
                  2 * color(0, c) * color(1, c) * product(i, 0, 1) +
                  color(1, c) * color(1, c) * product(i, 1, 1);
      total += energy[c];
    }
    for (size_t m = 0; m < n_samples; ++m) {
      if (m == i) continue;
      const float* diagonal = &gram[m * max_lobes * (n_lobes + 1)];
      const TwoLobes lobes{diagonal[0], diagonal[1], diagonal[n_lobes + 1]};
      float cost = 0;
      for (size_t c = 0; c < 3; ++c) {
        const float r0 = color(0, c) * product(m, 0, 0) + color(1, c) * product(m, 0, 1);
        const float r1 = color(0, c) * product(m, 1, 0) + color(1, c) * product(m, 1, 1);
        cost += std::max(0.0f, energy[c] - explained(lobes, r0, r1));
      }
      const dvec3 d = position_of(sample) - position_of(samples[m]);
      cost += total * static_cast<float>(std::min(per_square * glm::dot(d, d), 1e6));
      costs[m * n_samples + i] = cost;
    }
  }
  return costs;
}

}  // namespace relume

#include "reduction/methods/light_fit_pixel.h"

#include <algorithm>

#include "core/simd/dot_products.h"

namespace relume {
namespace {

static_assert(max_lobes == 2);

dvec3 position_of(const FitSample& sample) {
  return {sample.vector[0], sample.vector[1], sample.vector[2]};
}

/// What the costs of a cluster are made of, with all samples side by side so that the loops over
/// them vectorise.
class SampleArrays {
 public:
  explicit SampleArrays(const FitPixel& pixel)
      : n_(pixel.samples.size()), values_(n_ * array_count) {
    const LobeEvaluator& evaluator = pixel.evaluator;
    const auto columns = static_cast<size_t>(pixel.columns);
    dvec3 mean(0);
    for (const FitSample& s : pixel.samples) mean += position_of(s);
    mean /= static_cast<double>(n_);
    double spread = 0;
    for (size_t i = 0; i < n_; ++i) {
      const FitSample& sample = pixel.samples[i];
      const dvec3 offset = position_of(sample) - mean;
      spread += glm::dot(offset, offset);
      for (size_t c = 0; c < 3; ++c) {
        array(position + c)[i] = static_cast<float>(offset[c]);
        for (int k = 0; k < evaluator.lobe_count(sample.type); ++k) {
          array(color + 3 * k + c)[i] =
              sample.vector[evaluator.color_offset(sample.type, k) + static_cast<int>(c)];
        }
        float squares = 0;
        for (size_t j = 0; j < columns; ++j) {
          squares += sample.v[c * columns + j] * sample.v[c * columns + j];
        }
        array(energy + c)[i] = squares;
      }
    }
    inverse_square_ = spread > 0 ? static_cast<float>(static_cast<double>(n_) / (2 * spread)) : 0;
    if (!is_finite(inverse_square_)) inverse_square_ = 0;
  }

  /// costs[i]: see FitPixel::unexplained. products[(a * 2 + b) * n + i] is that of the candidate's
  /// lobe a with sample i's lobe b.
  void add_costs(size_t candidate, const float* products, float position_weight,
                 float* costs) const {
    // Products of the candidate's lobes with each other.
    const float a = products[candidate];
    const float b = products[n_ + candidate];
    const float d = products[3 * n_ + candidate];
    // A lobe that next to no light hits explains nothing; nor do two that are nearly the same more
    // than one of them.
    const float least = 1e-12f * std::max(a, d);
    const float inverse_a = a > least ? 1 / a : 0;
    const float inverse_d = d > least ? 1 / d : 0;
    const float determinant = a * d - b * b;
    const bool two = a > least && d > least && determinant > 1e-4f * a * d;
    const float inverse_determinant = two ? 1 / determinant : 0;
    for (size_t c = 0; c < 3; ++c) {
      const float* first = array(color + c);
      const float* second = array(color + 3 + c);
      const float* squares = array(energy + c);
      for (size_t i = 0; i < n_; ++i) {
        // The squared length of the best approximation of the sample's channel with colours >= 0:
        // both lobes where both colours come out positive, else the better one.
        const float r0 = first[i] * products[i] + second[i] * products[n_ + i];
        const float r1 = first[i] * products[2 * n_ + i] + second[i] * products[3 * n_ + i];
        const float x = d * r0 - b * r1;
        const float y = a * r1 - b * r0;
        const float p0 = std::max(r0, 0.0f);
        const float p1 = std::max(r1, 0.0f);
        const float one_lobe = std::max(p0 * p0 * inverse_a, p1 * p1 * inverse_d);
        const float both = (x * r0 + y * r1) * inverse_determinant;
        const float explained = x >= 0 && y >= 0 && two ? both : one_lobe;
        costs[i] += std::max(0.0f, squares[i] - explained);
      }
    }
    const float weight = position_weight * inverse_square_;
    const float* p[3] = {array(position), array(position + 1), array(position + 2)};
    for (size_t i = 0; i < n_; ++i) {
      const float dx = p[0][i] - p[0][candidate];
      const float dy = p[1][i] - p[1][candidate];
      const float dz = p[2][i] - p[2][candidate];
      const float total = array(energy)[i] + array(energy + 1)[i] + array(energy + 2)[i];
      costs[i] += total * weight * (dx * dx + dy * dy + dz * dz);
    }
  }

 private:
  static constexpr size_t position = 0;
  static constexpr size_t color = 3;
  static constexpr size_t energy = color + 3 * size_t{max_lobes};
  static constexpr size_t array_count = energy + 3;

  float* array(size_t index) { return &values_[index * n_]; }
  const float* array(size_t index) const { return &values_[index * n_]; }

  size_t n_;
  std::vector<float> values_;
  float inverse_square_ = 0;
};

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

MedoidCosts FitPixel::unexplained(float position_weight, int max_candidates) const {
  const auto n_samples = static_cast<size_t>(n());
  MedoidCosts costs;
  const int count = std::min(n(), max_candidates);
  for (int m = 0; m < count; ++m) {
    costs.candidates.push_back(static_cast<int>(int64_t{m} * n() / count));
  }
  costs.values.resize(costs.candidates.size() * n_samples);
  const SampleArrays arrays(*this);
  std::vector<float> products(size_t{4} * n_samples);
  for (size_t m = 0; m < costs.candidates.size(); ++m) {
    const auto candidate = static_cast<size_t>(costs.candidates[m]);
    for (int b = 0; b < max_lobes; ++b) {
      dot_products(samples[candidate].lobes, max_lobes, columns,
                   &lobes_[static_cast<size_t>(b) * columns], n(), max_lobes * columns, columns,
                   &products[static_cast<size_t>(b) * n_samples], max_lobes * n());
    }
    float* row = &costs.values[m * n_samples];
    arrays.add_costs(candidate, products.data(), position_weight, row);
    row[candidate] = 0;
  }
  return costs;
}

}  // namespace relume

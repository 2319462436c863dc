#include "core/relight/frame_cost.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/relight/kernel.h"

namespace relume {
namespace {

/// Weight that is left of what a new measurement tells anew.
constexpr double kept = 0.8;

/// How much the typical proportions count against one measurement, where those say nothing.
constexpr double prior_weight = 1e-4;

template <class Terms>
double dot(const Terms& a, const Terms& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Solves matrix x = right by elimination; `matrix` is symmetric and positive definite.
template <class Matrix, class Terms>
Terms solve_positive(Matrix matrix, Terms right) {
  const size_t count = right.size();
  for (size_t pivot = 0; pivot < count; ++pivot) {
    for (size_t i = pivot + 1; i < count; ++i) {
      const double multiple = matrix[i][pivot] / matrix[pivot][pivot];
      for (size_t j = pivot; j < count; ++j) matrix[i][j] -= multiple * matrix[pivot][j];
      right[i] -= multiple * right[pivot];
    }
  }
  for (size_t i = count; i-- > 0;) {
    for (size_t j = i + 1; j < count; ++j) right[i] -= matrix[i][j] * right[j];
    right[i] /= matrix[i][i];
  }
  return right;
}

}  // namespace

FrameWork make_frame_work(const RelightCache& cache, int changed_lights, int combined_layers) {
  FrameWork work{static_cast<double>(cache.info().record_count), 0, changed_lights,
                 combined_layers};
  for (const PackedTile& tile : cache.tiles()) {
    if (tile.block_count > 0) work.pixels += static_cast<double>(tile.width) * tile.height;
  }
  return work;
}

/// In milliseconds at typical rates: the first measurements scale them together, later ones each.
FrameCost::Terms FrameCost::terms_of(const FrameWork& work) {
  const int passes = (work.changed_lights + max_kernel_lights - 1) / max_kernel_lights;
  return {0.02,
          5e-7 * work.records * passes,
          5e-7 * work.records * work.changed_lights,
          1e-6 * work.pixels * work.changed_lights,
          6e-7 * work.pixels * work.combined_layers,
          1e-6 * work.pixels};
}

/// Lets fade what is known in the direction of `z`, and nothing else.
void FrameCost::forget(const Terms& z) {
  Terms known;
  for (int i = 0; i < term_count; ++i) known[i] = dot(information_[i], z);
  const double amount = dot(known, z);
  if (!(amount > 0)) return;
  const double told = dot(vector_, z);
  for (int i = 0; i < term_count; ++i) {
    for (int j = 0; j < term_count; ++j) {
      information_[i][j] -= (1 - kept) * known[i] * known[j] / amount;
    }
    vector_[i] -= (1 - kept) * known[i] * told / amount;
  }
}

/// The rates of least relative error, near the typical ones times one factor. A rate that would be
/// negative is 0 instead, the most negative first.
void FrameCost::solve() {
  const Terms ones{1, 1, 1, 1, 1, 1};
  double curvature = 0;
  for (const Terms& row : information_) curvature += dot(row, ones);
  const double factor = dot(vector_, ones) / curvature;
  if (!(factor > 0)) return;
  const double prior = prior_weight / (factor * factor);
  std::array<bool, term_count> is_zero{};
  for (;;) {
    std::array<Terms, term_count> matrix = information_;
    Terms right = vector_;
    for (int i = 0; i < term_count; ++i) {
      matrix[i][i] += prior;
      right[i] += prior * factor;
      if (!is_zero[i]) continue;
      for (int j = 0; j < term_count; ++j) matrix[i][j] = matrix[j][i] = i == j ? 1 : 0;
      right[i] = 0;
    }
    rates_ = solve_positive(matrix, right);
    const auto worst = std::min_element(rates_.begin(), rates_.end());
    if (*worst >= 0) return;
    is_zero[worst - rates_.begin()] = true;
  }
}

void FrameCost::add_measurement(const FrameWork& work, double ms) {
  if (!(ms > 0) || !std::isfinite(ms)) return;
  Terms z = terms_of(work);
  for (double& term : z) term /= ms;
  forget(z);
  for (int i = 0; i < term_count; ++i) {
    for (int j = 0; j < term_count; ++j) information_[i][j] += z[i] * z[j];
    vector_[i] += z[i];
  }
  ++measurements_;
  solve();
}

double FrameCost::predict_ms(const FrameWork& work) const {
  return dot(terms_of(work), rates_);
}

}  // namespace relume

#include "reduction/methods/light_fit_records.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/math/frame.h"
#include "core/simd/dot_products.h"
#include "reduction/methods/cholesky.h"

namespace relume {
namespace {

constexpr int geometry_count = lobe_derivatives;  // direction (2) and ln scalar (1)
constexpr float largest_turn = 0.5f;              // per step, radians
constexpr float largest_log_step = 1.0f;
constexpr double exact_fit = 1e-12;  // squared, relative: below this rounding would steer the fit

vec3 direction_of(const FitRecord& record, int offset) {
  return {record.vector[offset], record.vector[offset + 1], record.vector[offset + 2]};
}

/// Pulls `direction` back into the record's cone.
vec3 clamp_to_cone(const FitRecord& record, vec3 direction) {
  const float cosine = glm::dot(direction, record.cone_axis);
  if (cosine >= record.cone_cos) return direction;
  const vec3 side =
      normalize_or(direction - record.cone_axis * cosine, make_frame(record.cone_axis).tangent);
  const float sine = std::sqrt(std::max(0.0f, 1 - record.cone_cos * record.cone_cos));
  return normalize_or(record.cone_axis * record.cone_cos + side * sine, record.cone_axis);
}

}  // namespace

RecordFitter::RecordFitter(const LobeEvaluator& evaluator, std::span<const float> column_scale)
    : evaluator_(evaluator), scale_(column_scale), columns_(column_scale.size()) {}

void RecordFitter::evaluate(const std::vector<FitRecord>& records, Responses& responses) {
  responses.lobes.resize(records.size() * max_lobes * 4 * columns_);
  for (size_t r = 0; r < records.size(); ++r) {
    const FitRecord& record = records[r];
    const Frame frame = make_frame(direction_of(record, evaluator_.direction_offset(record.type)));
    float* out = &responses.lobes[r * max_lobes * 4 * columns_];
    const size_t rows = size_t(evaluator_.lobe_count(record.type)) * 4;
    evaluator_.lobes_and_derivatives(record.type, record.vector.data(), frame.tangent,
                                     frame.bitangent, out);
    for (size_t row = 0; row < rows; ++row) {
      for (size_t j = 0; j < columns_; ++j) out[row * columns_ + j] *= scale_[j];
    }
    std::fill(out + rows * columns_, out + max_lobes * 4 * columns_, 0.0f);
  }
  responses.cost = objective(records, responses);
}

void RecordFitter::add_response(const FitRecord& record, const float* lobes, float* out) const {
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < max_lobes; ++k) {
      const float color = record.color[k][c];
      if (color == 0) continue;
      const float* value = lobes + size_t(k) * 4 * columns_;
      for (size_t j = 0; j < columns_; ++j) out[c * columns_ + j] += color * value[j];
    }
  }
}

double RecordFitter::objective(const std::vector<FitRecord>& records, const Responses& responses) {
  const size_t length = 3 * columns_;
  own_.resize(records.size() * length);
  residual_.assign(length, 0.0f);
  double cost = 0;
  for (size_t r = 0; r < records.size(); ++r) {
    float* own = &own_[r * length];
    for (size_t i = 0; i < length; ++i) own[i] = -(*targets_)[r * length + i];
    add_response(records[r], lobe(responses, r, 0, 0), own);
    float own_squares = 0;
    dot_products(own, 1, 0, own, 1, 0, static_cast<int>(length), &own_squares, 1);
    cost += double{rho_} * own_squares;
    for (size_t i = 0; i < length; ++i) residual_[i] += own[i];
    for (int k = 0; k < max_lobes; ++k) {
      for (int c = 0; c < 3; ++c) {
        const double d = records[r].color[k][c] - records[r].prior[k][c];
        cost += double{mu_} * energy_[r * max_lobes + k] * d * d;
      }
    }
  }
  float squares = 0;
  dot_products(residual_.data(), 1, 0, residual_.data(), 1, 0, static_cast<int>(length), &squares,
               1);
  return cost + squares;
}

void RecordFitter::build_system(const std::vector<FitRecord>& records, const Responses& responses) {
  const size_t n = records.size();
  const size_t n_v = n * max_lobes;
  const size_t n_g = n * geometry_count;
  const size_t length = 3 * columns_;
  values_.resize(n_v * columns_);
  geometry_.assign(n_g * length, 0.0f);
  for (size_t r = 0; r < n; ++r) {
    for (int k = 0; k < max_lobes; ++k) {
      std::copy_n(lobe(responses, r, k, 0), columns_, &values_[(r * max_lobes + k) * columns_]);
      for (int p = 0; p < geometry_count; ++p) {
        const float* derivative = lobe(responses, r, k, 1 + p);
        float* out = &geometry_[(r * geometry_count + p) * length];
        for (int c = 0; c < 3; ++c) {
          const float color = records[r].color[k][c];
          for (size_t j = 0; j < columns_; ++j) out[c * columns_ + j] += color * derivative[j];
        }
      }
    }
  }
  const auto product = [this](const float* a, size_t a_rows, size_t a_stride, const float* b,
                              size_t b_rows, size_t b_stride, size_t count,
                              std::vector<double>& out) {
    products_.resize(a_rows * b_rows);
    dot_products(a, static_cast<int>(a_rows), static_cast<int>(a_stride), b,
                 static_cast<int>(b_rows), static_cast<int>(b_stride), static_cast<int>(count),
                 products_.data(), static_cast<int>(b_rows));
    out.assign(products_.begin(), products_.end());
  };
  product(values_.data(), n_v, columns_, values_.data(), n_v, columns_, columns_, h_vv_);
  product(geometry_.data(), n_g, length, geometry_.data(), n_g, length, length, h_gg_);
  product(geometry_.data(), n_g, length, residual_.data(), 1, 0, length, b_g_);
  std::vector<double> own_product;
  for (size_t r = 0; r < n; ++r) {
    product(&geometry_[r * geometry_count * length], geometry_count, length, &own_[r * length], 1,
            0, length, own_product);
    for (int p = 0; p < geometry_count; ++p) {
      b_g_[r * geometry_count + p] += rho_ * own_product[p];
      for (int q = 0; q < geometry_count; ++q) {
        h_gg_[(r * geometry_count + p) * n_g + r * geometry_count + q] *= 1 + rho_;
      }
    }
    for (int k = 0; k < max_lobes; ++k) {
      for (int m = 0; m < max_lobes; ++m) {
        h_vv_[(r * max_lobes + k) * n_v + r * max_lobes + m] *= 1 + rho_;
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    product(values_.data(), n_v, columns_, &geometry_[c * columns_], n_g, length, columns_,
            h_vg_[c]);
    product(values_.data(), n_v, columns_, &residual_[c * columns_], 1, 0, columns_, b_v_[c]);
    for (size_t r = 0; r < n; ++r) {
      product(&values_[r * max_lobes * columns_], max_lobes, columns_,
              &own_[r * length + c * columns_], 1, 0, columns_, own_product);
      for (int k = 0; k < max_lobes; ++k) {
        const size_t i = r * max_lobes + k;
        b_v_[c][i] += rho_ * own_product[k] +
                      mu_ * energy_[i] * (records[r].color[k][c] - records[r].prior[k][c]);
        for (int p = 0; p < geometry_count; ++p)
          h_vg_[c][i * n_g + r * geometry_count + p] *= 1 + rho_;
      }
    }
  }
}

bool RecordFitter::solve(const std::vector<FitRecord>& records, double damping) {
  const size_t n_v = records.size() * max_lobes;
  const size_t n_g = records.size() * geometry_count;
  std::vector<double> schur = h_gg_;
  for (size_t i = 0; i < n_g; ++i) schur[i * n_g + i] += damping * h_gg_[i * n_g + i];
  step_g_ = b_g_;
  std::vector<double> factor[3];
  std::vector<double> cross[3];
  for (int c = 0; c < 3; ++c) {
    factor[c] = h_vv_;
    cross[c] = h_vg_[c];
    step_v_[c] = b_v_[c];
    for (size_t i = 0; i < n_v; ++i) {
      factor[c][i * n_v + i] = (1 + damping) * (h_vv_[i * n_v + i] + mu_ * energy_[i]);
      const FitRecord& record = records[i / max_lobes];
      const size_t k = i % max_lobes;
      const float color = record.color[k][c];
      const bool pinned = record.upper[k][c] <= 0 || (color <= 0 && b_v_[c][i] > 0) ||
                          (color >= record.upper[k][c] && b_v_[c][i] < 0) ||
                          !(factor[c][i * n_v + i] > 0);
      if (!pinned) continue;
      for (size_t j = 0; j < n_v; ++j) factor[c][i * n_v + j] = factor[c][j * n_v + i] = 0;
      for (size_t j = 0; j < n_g; ++j) cross[c][i * n_g + j] = 0;
      factor[c][i * n_v + i] = 1;
      step_v_[c][i] = 0;
    }
    if (!factor_cholesky(factor[c], n_v)) return false;
    // Schur complement: schur -= cross^T H^-1 cross, with half-solved rows L^-1 cross.
    std::vector<double> half = cross[c];
    forward_substitute(factor[c], n_v, half, n_g);
    std::vector<double> half_b = step_v_[c];
    forward_substitute(factor[c], n_v, half_b, 1);
    for (size_t row = 0; row < n_v; ++row) {
      const double* h = &half[row * n_g];
      for (size_t i = 0; i < n_g; ++i) {
        step_g_[i] -= h[i] * half_b[row];
        for (size_t j = 0; j <= i; ++j) schur[i * n_g + j] -= h[i] * h[j];  // lower triangle only
      }
    }
  }
  for (size_t i = 0; i < n_g; ++i) {
    // A direction or scalar without effect (black lobes, no scalar) stays where it is.
    if (h_gg_[i * n_g + i] > 0) continue;
    for (size_t j = 0; j < n_g; ++j) schur[i * n_g + j] = schur[j * n_g + i] = 0;
    schur[i * n_g + i] = 1;
    step_g_[i] = 0;
  }
  if (!factor_cholesky(schur, n_g)) return false;
  forward_substitute(schur, n_g, step_g_, 1);
  backward_substitute(schur, n_g, step_g_, 1);
  for (int c = 0; c < 3; ++c) {
    for (size_t i = 0; i < n_v; ++i) {
      for (size_t j = 0; j < n_g; ++j) step_v_[c][i] -= cross[c][i * n_g + j] * step_g_[j];
    }
    forward_substitute(factor[c], n_v, step_v_[c], 1);
    backward_substitute(factor[c], n_v, step_v_[c], 1);
  }
  return true;
}

std::vector<FitRecord> RecordFitter::step(const std::vector<FitRecord>& records) const {
  std::vector<FitRecord> moved = records;
  for (size_t r = 0; r < moved.size(); ++r) {
    FitRecord& record = moved[r];
    for (int k = 0; k < max_lobes; ++k) {
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<float>(record.color[k][c] - step_v_[c][r * max_lobes + k]);
        record.color[k][c] = std::clamp(value, 0.0f, record.upper[k][c]);
      }
    }
    const int offset = evaluator_.direction_offset(record.type);
    const vec3 direction = direction_of(record, offset);
    const Frame frame = make_frame(direction);
    const double* g = &step_g_[r * geometry_count];
    const auto turn = [](double angle) {
      return static_cast<float>(std::clamp(-angle, -double{largest_turn}, double{largest_turn}));
    };
    const vec3 turned = clamp_to_cone(
        record, normalize_or(direction + frame.tangent * turn(g[0]) + frame.bitangent * turn(g[1]),
                             direction));
    for (int axis = 0; axis < 3; ++axis) record.vector[offset + axis] = turned[axis];
    const int scalar = evaluator_.scalar_offset(record.type);
    if (scalar >= 0) {
      const double log_step =
          std::clamp(-g[2], -double{largest_log_step}, double{largest_log_step});
      const auto value = static_cast<float>(record.vector[scalar] * std::exp(log_step));
      record.vector[scalar] = std::clamp(value, record.scalar_low, record.scalar_high);
    }
  }
  return moved;
}

void RecordFitter::fit(std::vector<FitRecord>& records, const std::vector<float>& targets,
                       float rho, float mu, int steps) {
  CHECK_MSG(targets.size() == records.size() * 3 * columns_, "targets {} records {} columns {}",
            targets.size(), records.size(), columns_);
  rho_ = rho;
  mu_ = mu;
  targets_ = &targets;
  energy_.assign(records.size() * max_lobes, 0.0f);
  Responses current;
  evaluate(records, current);
  for (size_t r = 0; r < records.size(); ++r) {
    for (int k = 0; k < max_lobes; ++k) {
      const float* value = lobe(current, r, k, 0);
      float* energy = &energy_[r * max_lobes + k];
      dot_products(value, 1, 0, value, 1, 0, static_cast<int>(columns_), energy, 1);
      // A lobe that few training lights hit is held by its prior as if it had a little energy.
      if (k > 0) *energy = std::max(*energy, 0.05f * energy_[r * max_lobes]);
    }
  }
  current.cost = objective(records, current);
  float target_squares = 0;
  dot_products(targets.data(), 1, 0, targets.data(), 1, 0, static_cast<int>(targets.size()),
               &target_squares, 1);
  const double good_enough = exact_fit * target_squares;
  Responses trial;
  double damping = 1e-3;
  for (int i = 0; i < steps && current.cost > good_enough; ++i) {
    build_system(records, current);
    if (!solve(records, damping)) {
      damping *= 100;
      continue;
    }
    std::vector<FitRecord> moved = step(records);
    evaluate(moved, trial);
    if (trial.cost < current.cost) {
      const bool converged = current.cost - trial.cost < 1e-4 * current.cost;
      records = std::move(moved);
      std::swap(current, trial);
      damping = std::max(damping * 0.3, 1e-7);
      if (converged) break;
    } else {
      objective(records, current);  // restores the residuals of the current records
      damping *= 10;
      if (!(damping < 1e6)) break;
    }
  }
}

}  // namespace relume

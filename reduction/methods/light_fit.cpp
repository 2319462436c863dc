#include "reduction/methods/light_fit.h"

#include <algorithm>
#include <optional>

#include "core/base/check.h"
#include "core/simd/dot_products.h"
#include "reduction/methods/kmedoids.h"
#include "reduction/methods/light_fit_records.h"

namespace relume {
namespace {

constexpr float smallest_cone_rad = 0.2f;
constexpr int max_exchanges = 30;
constexpr int max_candidates = 64;  // for medoids: of 256 samples every fourth

/// One cluster's own target, prior and members.
struct Cluster {
  std::vector<int> members;
  std::vector<float> target;  ///< 3 x columns
  float diffuse[3] = {};      ///< sum over members of the first lobe's colour
};

std::vector<Cluster> make_clusters(const FitPixel& pixel, const std::vector<int>& cluster_of) {
  const int count = 1 + *std::max_element(cluster_of.begin(), cluster_of.end());
  std::vector<Cluster> clusters(count);
  const size_t length = static_cast<size_t>(3) * pixel.columns;
  for (Cluster& cluster : clusters) cluster.target.assign(length, 0.0f);
  for (int i = 0; i < pixel.n(); ++i) {
    Cluster& cluster = clusters[cluster_of[i]];
    const FitSample& sample = pixel.samples[i];
    cluster.members.push_back(i);
    for (size_t x = 0; x < length; ++x) cluster.target[x] += pixel.weight * sample.v[x];
    for (int c = 0; c < 3; ++c) {
      cluster.diffuse[c] +=
          pixel.weight * sample.vector[pixel.evaluator.color_offset(sample.type, 0) + c];
    }
  }
  return clusters;
}

/// The record that stands for `cluster` with member `anchor`'s geometry: bounds and prior, colours
/// at the prior.
FitRecord make_record(const FitPixel& pixel, const Cluster& cluster, int anchor) {
  const FitSample& chosen = pixel.samples[anchor];
  const LobeEvaluator& evaluator = pixel.evaluator;
  FitRecord record;
  record.type = chosen.type;
  record.vector.assign(chosen.vector, chosen.vector + evaluator.vector_width(chosen.type));
  const int direction = evaluator.direction_offset(chosen.type);
  const int scalar = evaluator.scalar_offset(chosen.type);
  record.cone_axis =
      vec3(chosen.vector[direction], chosen.vector[direction + 1], chosen.vector[direction + 2]);
  float cosine = std::cos(smallest_cone_rad);
  if (scalar >= 0) record.scalar_low = record.scalar_high = chosen.vector[scalar];
  for (int c = 0; c < 3; ++c) record.prior[0][c] = cluster.diffuse[c];
  for (const int i : cluster.members) {
    const FitSample& member = pixel.samples[i];
    if (member.type != chosen.type) continue;
    const float* d = member.vector + direction;
    const float side = glm::dot(record.cone_axis, vec3(d[0], d[1], d[2]));
    cosine = std::min(cosine, evaluator.is_axis(chosen.type) ? std::abs(side) : side);
    if (scalar >= 0) {
      record.scalar_low = std::min(record.scalar_low, member.vector[scalar]);
      record.scalar_high = std::max(record.scalar_high, member.vector[scalar]);
    }
    for (int k = 1; k < evaluator.lobe_count(chosen.type); ++k) {
      for (int c = 0; c < 3; ++c) {
        record.prior[k][c] +=
            pixel.weight * member.vector[evaluator.color_offset(chosen.type, k) + c];
      }
    }
  }
  record.cone_cos = cosine;
  if (scalar >= 0) {
    record.scalar_low *= 0.6f;
    record.scalar_high = std::min(1.5f * record.scalar_high, evaluator.largest_scalar(chosen.type));
  }
  for (int k = 0; k < max_lobes; ++k) {
    for (int c = 0; c < 3; ++c) {
      record.upper[k][c] = 2 * record.prior[k][c];
      record.color[k][c] = record.prior[k][c];
    }
  }
  return record;
}

/// Colours of `record` that fit the cluster's target best with the anchor's own lobes, held by the
/// prior; returns the squared error. One 2 x 2 non-negative problem per channel.
float fit_colors(const FitPixel& pixel, const Cluster& cluster, int anchor, float mu,
                 FitRecord& record) {
  const FitSample& sample = pixel.samples[anchor];
  const int columns = pixel.columns;
  float gram[max_lobes * max_lobes];
  float right[max_lobes * 3];
  float target_squares[3];
  dot_products(sample.lobes, max_lobes, columns, sample.lobes, max_lobes, columns, columns, gram,
               max_lobes);
  dot_products(sample.lobes, max_lobes, columns, cluster.target.data(), 3, columns, columns, right,
               3);
  float error = 0;
  const float prior0 = mu * gram[0];
  const float prior1 = mu * std::max(gram[3], 0.05f * gram[0]);
  for (int c = 0; c < 3; ++c) {
    const float* t = &cluster.target[static_cast<size_t>(c) * columns];
    dot_products(t, 1, 0, t, 1, 0, columns, &target_squares[c], 1);
    const float a = gram[0] + prior0;
    const float d = gram[3] + prior1;
    const float r0 = right[c] + prior0 * record.prior[0][c];
    const float r1 = right[3 + c] + prior1 * record.prior[1][c];
    const float determinant = a * d - gram[1] * gram[1];
    const bool two = record.upper[1][c] > 0 && determinant > 1e-9f * a * d;
    float x = two ? (d * r0 - gram[1] * r1) / determinant : (a > 0 ? r0 / a : 0);
    float y = two ? (a * r1 - gram[1] * r0) / determinant : 0;
    if (two && x < 0) {
      x = 0;
      y = r1 / d;
    } else if (two && y < 0) {
      y = 0;
      x = r0 / a;
    }
    x = std::clamp(x, 0.0f, record.upper[0][c]);
    y = std::clamp(y, 0.0f, record.upper[1][c]);
    record.color[0][c] = x;
    record.color[1][c] = y;
    error += target_squares[c] + gram[0] * x * x + 2 * gram[1] * x * y + gram[3] * y * y -
             2 * (right[c] * x + right[3 + c] * y);
  }
  return error;
}

/// The member whose lobes fit the cluster best, with its colours.
FitRecord choose_anchor(const FitPixel& pixel, const Cluster& cluster, float mu) {
  std::optional<FitRecord> best;
  float least = 0;
  for (const int i : cluster.members) {
    FitRecord record = make_record(pixel, cluster, i);
    const float error = fit_colors(pixel, cluster, i, mu, record);
    if (best && !(error < least)) continue;
    least = error;
    best = std::move(record);
  }
  return *best;
}

FittedRecord finish_record(const FitPixel& pixel, const Cluster& cluster, const FitRecord& fitted) {
  FittedRecord record{
      fitted.type, pixel.weight * static_cast<float>(cluster.members.size()), fitted.vector, {}};
  for (const int i : cluster.members) {
    const FitSample& sample = pixel.samples[i];
    const bool is_strand = pixel.evaluator.is_axis(sample.type);
    record.members.push_back(
        {sample.vector, is_strand ? -1 : pixel.evaluator.direction_offset(sample.type)});
  }
  for (int k = 0; k < pixel.evaluator.lobe_count(fitted.type); ++k) {
    for (int c = 0; c < 3; ++c) {
      record.vector[pixel.evaluator.color_offset(fitted.type, k) + c] =
          fitted.color[k][c] / record.weight;
    }
  }
  return record;
}

}  // namespace

LightFit::LightFit(const LobeEvaluator& evaluator, const LightFitParams& params)
    : evaluator_(evaluator), params_(params), pixel_(evaluator) {
  for (int type = 0; type < evaluator.type_count(); ++type) {
    is_fitted_.push_back(evaluator.direction_offset(type) >= 0 && evaluator.lobe_count(type) >= 1);
  }
}

bool LightFit::load(std::span<const SampleMatrix> matrices, float weight_per_sample) {
  if (!pixel_.load(matrices, weight_per_sample, is_fitted_)) return false;
  unexplained_ = pixel_.unexplained(params_.position_weight, max_candidates);
  return std::all_of(unexplained_.values.begin(), unexplained_.values.end(),
                     [](float x) { return is_finite(x); });
}

std::vector<FittedRecord> LightFit::fit(int k) {
  CHECK_MSG(k >= 1 && k < pixel_.n(), "samples {} records {}", pixel_.n(), k);
  const std::vector<Cluster> clusters =
      make_clusters(pixel_, kmedoids(unexplained_, pixel_.n(), k, max_exchanges).cluster_of);
  RecordFitter fitter(evaluator_, pixel_.scale);
  std::vector<FitRecord> records;
  std::vector<float> targets;
  for (const Cluster& cluster : clusters) {
    std::vector<FitRecord> one{choose_anchor(pixel_, cluster, params_.mu)};
    fitter.fit(one, cluster.target, 0, params_.mu, params_.cluster_steps);
    records.push_back(std::move(one.front()));
    targets.insert(targets.end(), cluster.target.begin(), cluster.target.end());
  }
  if (params_.joint) fitter.fit(records, targets, params_.rho, params_.mu, params_.joint_steps);
  std::vector<FittedRecord> result;
  for (size_t r = 0; r < records.size(); ++r) {
    result.push_back(finish_record(pixel_, clusters[r], records[r]));
    for (const float x : result.back().vector) {
      if (!is_finite(x)) return {};
    }
  }
  return result;
}

}  // namespace relume

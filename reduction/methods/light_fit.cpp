#include "reduction/methods/light_fit.h"

#include <algorithm>
#include <optional>

#include "core/base/check.h"
#include "core/simd/dot_products.h"
#include "reduction/methods/light_fit_clusters.h"
#include "reduction/methods/light_fit_records.h"

namespace relume {
namespace {

constexpr float smallest_cone_rad = 0.2f;

/// All samples of a pixel in one list, types mixed.
struct Sample {
  int type;
  const float* vector;
  const float* v;      ///< 3 x columns, scaled
  const float* lobes;  ///< max_lobes x columns, scaled
};

struct Pixel {
  const LobeEvaluator& evaluator;
  int columns;
  float weight;              ///< of one sample
  std::vector<float> scale;  ///< per column
  std::vector<float> lobes;  ///< n x max_lobes x columns, scaled and padded with zeros
  std::vector<float> v;      ///< n x 3 x columns, scaled
  std::vector<Sample> samples;

  int n() const { return static_cast<int>(samples.size()); }
};

/// The factor of each column: the light's mean weight, over the size of the pixel's response, so
/// that everything that follows is of order 1. Nothing when the pixel is black.
std::optional<std::vector<float>> column_scale(const LightSet& lights,
                                               const PixelResponses& responses) {
  double squares = 0;
  for (const float value : responses.target) squares += double{value} * value;
  if (!(squares > 0) || !std::isfinite(squares)) return std::nullopt;
  const double norm = 1 / std::sqrt(squares);
  std::vector<float> scale;
  for (int j = 0; j < responses.columns; ++j) {
    const double weight =
        (double{lights.weights[0][j]} + lights.weights[1][j] + lights.weights[2][j]) / 3;
    scale.push_back(static_cast<float>(weight * norm));
    if (!is_finite(scale.back())) return std::nullopt;
  }
  return scale;
}

/// Scales lobes and recomputes responses to white lights.
Pixel make_pixel(const LobeEvaluator& evaluator, std::span<const SampleMatrix> matrices,
                 float weight, const PixelResponses& responses, std::vector<float> scale) {
  Pixel pixel{evaluator, responses.columns, weight, std::move(scale), {}, {}, {}};
  const auto columns = static_cast<size_t>(pixel.columns);
  size_t n = 0;
  for (const SampleMatrix& matrix : matrices) n += static_cast<size_t>(matrix.rows);
  pixel.lobes.assign(n * max_lobes * columns, 0.0f);
  pixel.v.assign(n * 3 * columns, 0.0f);
  for (size_t t = 0; t < matrices.size(); ++t) {
    const int type = static_cast<int>(t);
    for (int row = 0; row < matrices[t].rows; ++row) {
      const size_t i = pixel.samples.size();
      const float* vector = matrices[t].row(row);
      float* lobes = &pixel.lobes[i * max_lobes * columns];
      float* v = &pixel.v[i * 3 * columns];
      for (int k = 0; k < evaluator.lobe_count(type); ++k) {
        const float* source =
            &responses.lobes[t][(static_cast<size_t>(row) * max_lobes + k) * columns];
        float* lobe = lobes + k * columns;
        for (size_t j = 0; j < columns; ++j) lobe[j] = source[j] * pixel.scale[j];
        for (int c = 0; c < 3; ++c) {
          const float color = vector[evaluator.color_offset(type, k) + c];
          for (size_t j = 0; j < columns; ++j) v[c * columns + j] += color * lobe[j];
        }
      }
      pixel.samples.push_back({type, vector, v, lobes});
    }
  }
  return pixel;
}

/// Position about the pixel's mean over their spread, and direction: 6 numbers a sample, padded
/// to 16.
std::vector<float> shape_features(const Pixel& pixel) {
  std::vector<float> features(static_cast<size_t>(pixel.n()) * 16, 0.0f);
  dvec3 mean(0);
  for (const Sample& s : pixel.samples) mean += dvec3(s.vector[0], s.vector[1], s.vector[2]);
  mean /= pixel.n();
  double spread = 0;
  for (const Sample& s : pixel.samples) {
    const dvec3 d = dvec3(s.vector[0], s.vector[1], s.vector[2]) - mean;
    spread += glm::dot(d, d);
  }
  const double scale = spread > 0 ? std::sqrt(pixel.n() / spread) : 0;
  const Sample& first = pixel.samples.front();
  const float* reference = first.vector + pixel.evaluator.direction_offset(first.type);
  for (int i = 0; i < pixel.n(); ++i) {
    const Sample& s = pixel.samples[i];
    float* out = &features[static_cast<size_t>(i) * 16];
    for (int axis = 0; axis < 3; ++axis) {
      out[axis] = static_cast<float>((s.vector[axis] - mean[axis]) * scale);
    }
    const float* direction = s.vector + pixel.evaluator.direction_offset(s.type);
    const float side =
        direction[0] * reference[0] + direction[1] * reference[1] + direction[2] * reference[2];
    // Strand tangents have no sign; turning all types' directions alike keeps normals apart too.
    const float sign = pixel.evaluator.is_axis(s.type) && side < 0 ? -1.0f : 1.0f;
    for (int axis = 0; axis < 3; ++axis) out[3 + axis] = sign * direction[axis];
  }
  return features;
}

/// Kernel of the clustering: response Gram matrix over its trace plus shape Gram over its.
std::vector<float> clustering_kernel(const Pixel& pixel, float position_weight) {
  const int n = pixel.n();
  const size_t size = static_cast<size_t>(n) * n;
  std::vector<float> kernel(size);
  std::vector<float> shape(size);
  dot_products(pixel.v.data(), n, 3 * pixel.columns, pixel.v.data(), n, 3 * pixel.columns,
               3 * pixel.columns, kernel.data(), n);
  const std::vector<float> features = shape_features(pixel);
  dot_products(features.data(), n, 16, features.data(), n, 16, 16, shape.data(), n);
  float response_trace = 0;
  float shape_trace = 0;
  for (int i = 0; i < n; ++i) {
    response_trace += kernel[static_cast<size_t>(i) * n + i];
    shape_trace += shape[static_cast<size_t>(i) * n + i];
  }
  const float a = response_trace > 0 ? 1 / response_trace : 0;
  const float b = shape_trace > 0 ? position_weight / shape_trace : 0;
  for (size_t i = 0; i < size; ++i) kernel[i] = a * kernel[i] + b * shape[i];
  return kernel;
}

/// One cluster's own target, prior and members.
struct Cluster {
  std::vector<int> members;
  std::vector<float> target;  ///< 3 x columns
  float diffuse[3] = {};      ///< sum over members of the first lobe's colour
};

std::vector<Cluster> make_clusters(const Pixel& pixel, const std::vector<int>& cluster_of) {
  const int count = 1 + *std::max_element(cluster_of.begin(), cluster_of.end());
  std::vector<Cluster> clusters(count);
  const size_t length = static_cast<size_t>(3) * pixel.columns;
  for (Cluster& cluster : clusters) cluster.target.assign(length, 0.0f);
  for (int i = 0; i < pixel.n(); ++i) {
    Cluster& cluster = clusters[cluster_of[i]];
    const Sample& sample = pixel.samples[i];
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
FitRecord make_record(const Pixel& pixel, const Cluster& cluster, int anchor) {
  const Sample& chosen = pixel.samples[anchor];
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
    const Sample& member = pixel.samples[i];
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
  record.scalar_low *= 0.6f;
  record.scalar_high *= 1.5f;
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
float fit_colors(const Pixel& pixel, const Cluster& cluster, int anchor, float mu,
                 FitRecord& record) {
  const Sample& sample = pixel.samples[anchor];
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
FitRecord choose_anchor(const Pixel& pixel, const Cluster& cluster, float mu) {
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

FittedRecord finish_record(const Pixel& pixel, const Cluster& cluster, const FitRecord& fitted) {
  FittedRecord record{fitted.type, pixel.weight * static_cast<float>(cluster.members.size()),
                      fitted.vector};
  for (int k = 0; k < pixel.evaluator.lobe_count(fitted.type); ++k) {
    for (int c = 0; c < 3; ++c) {
      record.vector[pixel.evaluator.color_offset(fitted.type, k) + c] =
          fitted.color[k][c] / record.weight;
    }
  }
  return record;
}

bool applies(const LobeEvaluator& evaluator, std::span<const SampleMatrix> matrices) {
  for (size_t t = 0; t < matrices.size(); ++t) {
    const int type = static_cast<int>(t);
    if (matrices[t].rows == 0) continue;
    if (evaluator.direction_offset(type) < 0 || evaluator.lobe_count(type) < 1) return false;
  }
  return true;
}

}  // namespace

std::vector<FittedRecord> light_fit(const LobeEvaluator& evaluator,
                                    std::span<const SampleMatrix> matrices, float weight_per_sample,
                                    const PixelResponses& responses, const LightFitParams& params,
                                    Random& random) {
  if (!applies(evaluator, matrices)) return {};
  auto scale = column_scale(evaluator.lights(), responses);
  if (!scale) return {};
  const Pixel pixel =
      make_pixel(evaluator, matrices, weight_per_sample, responses, std::move(*scale));
  CHECK_MSG(pixel.n() > params.records, "samples {} records {}", pixel.n(), params.records);
  const std::vector<float> kernel = clustering_kernel(pixel, params.position_weight);
  if (!std::all_of(kernel.begin(), kernel.end(), [](float x) { return is_finite(x); })) return {};
  const std::vector<Cluster> clusters = make_clusters(
      pixel, kernel_kmeans(kernel, pixel.n(), params.records, params.restarts, random));
  RecordFitter fitter(evaluator, pixel.scale);
  std::vector<FitRecord> records;
  std::vector<float> targets;
  for (const Cluster& cluster : clusters) {
    std::vector<FitRecord> one{choose_anchor(pixel, cluster, params.mu)};
    fitter.fit(one, cluster.target, 0, params.mu, params.cluster_steps);
    records.push_back(std::move(one.front()));
    targets.insert(targets.end(), cluster.target.begin(), cluster.target.end());
  }
  if (params.joint) fitter.fit(records, targets, params.rho, params.mu, params.joint_steps);
  std::vector<FittedRecord> result;
  for (size_t r = 0; r < records.size(); ++r) {
    result.push_back(finish_record(pixel, clusters[r], records[r]));
    for (const float x : result.back().vector) {
      if (!is_finite(x)) return {};
    }
  }
  return result;
}

double response_error(const LobeEvaluator& evaluator, std::span<const FittedRecord> records,
                      std::span<const float> target) {
  const LightSet& lights = evaluator.lights();
  const auto columns = static_cast<size_t>(lights.columns());
  std::vector<float> sum(3 * columns, 0.0f);
  std::vector<float> lobes(max_lobes * columns);
  std::vector<float> v(3 * columns);
  for (const FittedRecord& record : records) {
    evaluator.lobes(record.type, record.vector.data(), lobes.data());
    shade_rows(evaluator, record.type, record.vector.data(), 1, lobes.data(), v.data());
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += record.weight * v[i];
  }
  double squares = 0;
  for (size_t i = 0; i < sum.size(); ++i) {
    const double d = double{sum[i]} - target[i];
    squares += d * d;
  }
  return squares / (3.0 * std::max(1, lights.light_count));
}

}  // namespace relume

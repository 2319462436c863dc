#include "reduction/reduction.h"

#include <numeric>
#include <optional>

#include "core/base/check.h"
#include "reduction/allocation.h"
#include "reduction/merge.h"
#include "reduction/methods/cmeans.h"
#include "reduction/methods/kmeans.h"
#include "reduction/methods/kmedoids.h"
#include "reduction/methods/light_fit_reducer.h"
#include "reduction/methods/light_metric.h"

namespace relume {
namespace {

/// True for methods that give every type a record while k allows; the report's lose rare types.
bool keeps_types(ReductionMethod method) {
  return !is_report_method(method);
}

/// The pixel's own random numbers for one type; strong k-means and its kin share type 0's.
Random make_random(uint64_t seed, uint64_t pixel, size_t type) {
  return Random(seed, RandomStream::reduction, pixel + (uint64_t{type} << 40));
}

std::vector<SampleMatrix> pixel_matrices(const SampleTile& tile, std::span<const SampleType> types,
                                         int pixel) {
  std::vector<SampleMatrix> matrices;
  for (size_t t = 0; t < types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const uint32_t first = rows.first[pixel];
    matrices.push_back({&types[t], rows.values.data() + size_t{first} * types[t].width,
                        static_cast<int>(rows.first[pixel + 1] - first)});
  }
  return matrices;
}

/// The sum of a pixel's sample weights: its coverage.
double pixel_weight(const SampleTile& tile, int pixel) {
  double sum = 0;
  for (const TypedRows& rows : tile.types) {
    for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
      sum += rows.weights[row];
    }
  }
  return sum;
}

/// Reduces pixels one after the other, with buffers kept between them.
class PixelReducer {
 public:
  PixelReducer(std::span<const SampleType> types, const ReductionParams& params,
               const TrainingSet* training)
      : types_(types), params_(params) {
    if (training == nullptr) return;
    if (needs_validation(params.method)) {
      LightFitParams fit;
      fit.records = params.records;
      fit.restarts = params.restarts;
      fit.joint = params.method == ReductionMethod::light_fit;
      light_fit_.emplace(*training, fit);
    } else {
      light_metric_.emplace(*training);
    }
  }

  /// Appends the records of pixel `index` of the tile, which is number `pixel` of the image.
  void reduce(const SampleTile& samples, int index, uint64_t pixel, SampleTile& records) {
    const std::vector<SampleMatrix> matrices = pixel_matrices(samples, types_, index);
    std::vector<int> counts;
    for (const SampleMatrix& matrix : matrices) counts.push_back(matrix.rows);
    const std::vector<int> allocation =
        allocate_records(counts, params_.records, keeps_types(params_.method));
    // Eq. 3: a record weighs members / members of all clusters. Types without a record are lost and
    // the others grow to fill the pixel's coverage.
    int clustered = 0;
    for (size_t t = 0; t < counts.size(); ++t) clustered += allocation[t] > 0 ? counts[t] : 0;
    if (clustered == 0) return;
    const double coverage = pixel_weight(samples, index);
    const auto weight = static_cast<float>(coverage / clustered);
    const int total = std::accumulate(counts.begin(), counts.end(), 0);
    const auto weight_of_all = static_cast<float>(coverage / total);
    if (light_metric_ && allocation != counts) {
      light_metric_->prepare(params_.method, matrices, weight_of_all);
    }
    Random random = make_random(params_.seed, pixel, 0);
    if (light_fit_ && allocation != counts) {
      make_guard(matrices, allocation, weight, random);
      light_fit_->reduce(matrices, weight_of_all, guard_, random, records);
      return;
    }
    for (size_t t = 0; t < counts.size(); ++t) {
      if (allocation[t] == 0) continue;
      if (allocation[t] == counts[t]) {
        copy_rows(matrices[t], weight, records.types[t]);
      } else if (light_metric_) {
        Random draws = make_random(params_.seed, pixel, t);
        merge_clusters(matrices[t],
                       light_metric_->cluster(static_cast<int>(t), allocation[t], params_, draws),
                       weight, records.types[t]);
      } else {
        merge(matrices[t], allocation[t], weight, random, records.types[t]);
      }
    }
  }

 private:
  /// Strong k-means' records, for Light-Fit to beat.
  void make_guard(std::span<const SampleMatrix> matrices, std::span<const int> allocation,
                  float weight, Random& random) {
    guard_.assign(matrices.size(), {});
    for (size_t t = 0; t < matrices.size(); ++t) {
      if (allocation[t] == 0) continue;
      if (allocation[t] == matrices[t].rows) {
        copy_rows(matrices[t], weight, guard_[t]);
      } else {
        merge(matrices[t], allocation[t], weight, random, guard_[t]);
      }
    }
  }

  /// Clusters one type's samples into at most k records, 1 <= k < rows, and appends them.
  void merge(const SampleMatrix& samples, int k, float weight, Random& random, TypedRows& out) {
    if (params_.method == ReductionMethod::kmeans) {
      make_raw_features(samples, features_);
      first_k_.resize(k);
      std::iota(first_k_.begin(), first_k_.end(), 0);
      merge_clusters(samples, kmeans(features_, first_k_, params_.max_iterations), weight, out);
      return;
    }
    make_scaled_features(samples, params_.scene_radius, features_);
    switch (params_.method) {
      case ReductionMethod::strong_kmeans:
      case ReductionMethod::light_fit_fast:
      case ReductionMethod::light_fit:
        merge_clusters(
            samples, strong_kmeans(features_, k, params_.restarts, params_.max_iterations, random),
            weight, out);
        return;
      case ReductionMethod::kmedoids:
        merge_clusters(samples, kmedoids(features_, k, params_.max_iterations), weight, out);
        return;
      case ReductionMethod::cmeans:
        merge_fuzzy_clusters(samples,
                             cmeans(features_, k, params_.restarts, params_.max_iterations, random),
                             weight, out);
        return;
      default:
        CHECK_MSG(false, "method {}", static_cast<int>(params_.method));
    }
  }

  std::span<const SampleType> types_;
  const ReductionParams& params_;
  std::optional<LightMetric> light_metric_;
  std::optional<LightFitReducer> light_fit_;
  std::vector<TypedRows> guard_;
  Features features_;
  std::vector<int> first_k_;
};

}  // namespace

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

bool needs_validation(ReductionMethod method) {
  return method == ReductionMethod::light_fit_fast || method == ReductionMethod::light_fit;
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
                       const TrainingSet* training) {
  CHECK_MSG(params.records >= 1, "records {}", params.records);
  CHECK_MSG(!needs_training(params.method) || training != nullptr, "method {} needs training",
            label_of(reduction_method_labels, params.method));
  if (params.method == ReductionMethod::all || params.method == ReductionMethod::pure) {
    return samples;
  }
  SampleTile records;
  records.x0 = samples.x0;
  records.y0 = samples.y0;
  records.width = samples.width;
  records.height = samples.height;
  records.types.resize(types.size());
  for (TypedRows& rows : records.types) rows.first.push_back(0);
  PixelReducer reducer(types, params, needs_training(params.method) ? training : nullptr);
  for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    const int x = samples.x0 + pixel % samples.width;
    const int y = samples.y0 + pixel / samples.width;
    reducer.reduce(samples, pixel,
                   static_cast<uint64_t>(y) * static_cast<uint64_t>(image_width) + x, records);
    for (TypedRows& rows : records.types) {
      rows.first.push_back(static_cast<uint32_t>(rows.rows()));
    }
  }
  return records;
}

}  // namespace relume

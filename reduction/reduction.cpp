#include "reduction/reduction.h"

#include <numeric>

#include "core/base/check.h"
#include "reduction/allocation.h"
#include "reduction/merge.h"
#include "reduction/methods/kmeans.h"

namespace relume {
namespace {

/// Clusters one type's samples of one pixel into at most k clusters, 1 <= k < rows.
Clustering cluster(const SampleMatrix& samples, int k, const ReductionParams& params,
                   Random& random, Features& features) {
  if (params.method == ReductionMethod::kmeans) {
    make_raw_features(samples, features);
    std::vector<int> first_k(k);
    std::iota(first_k.begin(), first_k.end(), 0);
    return kmeans(features, first_k, params.max_iterations);
  }
  CHECK(params.method == ReductionMethod::strong_kmeans);
  make_scaled_features(samples, params.scene_radius, features);
  return strong_kmeans(features, k, params.restarts, params.max_iterations, random);
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

void reduce_pixel(const SampleTile& samples, std::span<const SampleType> types, int pixel,
                  const ReductionParams& params, Random& random, Features& features,
                  SampleTile& records) {
  const std::vector<SampleMatrix> matrices = pixel_matrices(samples, types, pixel);
  std::vector<int> counts;
  for (const SampleMatrix& matrix : matrices) counts.push_back(matrix.rows);
  const bool keep_types = params.method == ReductionMethod::strong_kmeans;
  const std::vector<int> allocation = allocate_records(counts, params.records, keep_types);
  // Eq. 3: a record weighs members / members of all clusters. Types without a record are lost and
  // the others grow to fill the pixel's coverage.
  int clustered = 0;
  for (size_t t = 0; t < counts.size(); ++t) clustered += allocation[t] > 0 ? counts[t] : 0;
  if (clustered == 0) return;
  const auto weight = static_cast<float>(pixel_weight(samples, pixel) / clustered);
  for (size_t t = 0; t < counts.size(); ++t) {
    if (allocation[t] == 0) continue;
    if (allocation[t] == counts[t]) {
      copy_rows(matrices[t], weight, records.types[t]);
    } else {
      merge_clusters(matrices[t], cluster(matrices[t], allocation[t], params, random, features),
                     weight, records.types[t]);
    }
  }
}

}  // namespace

SampleTile reduce_tile(const SampleTile& samples, std::span<const SampleType> types,
                       const ReductionParams& params, int image_width) {
  CHECK_MSG(params.records >= 1, "records {}", params.records);
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
  Features features;
  for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    const int x = samples.x0 + pixel % samples.width;
    const int y = samples.y0 + pixel / samples.width;
    Random random(params.seed, RandomStream::reduction,
                  static_cast<uint64_t>(y) * static_cast<uint64_t>(image_width) + x);
    reduce_pixel(samples, types, pixel, params, random, features, records);
    for (TypedRows& rows : records.types) {
      rows.first.push_back(static_cast<uint32_t>(rows.rows()));
    }
  }
  return records;
}

}  // namespace relume

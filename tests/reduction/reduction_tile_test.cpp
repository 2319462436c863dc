#include <gtest/gtest.h>

#include "core/shade/shader_list.h"
#include "reduction/allocation.h"
#include "reduction/methods/kmeans.h"
#include "reduction/reduction.h"
#include "tests/support/records.h"

namespace relume {
namespace {

using test::all_sample_types;
using test::make_random_tile;

uint32_t count_of(const SampleTile& tile, size_t type, int pixel) {
  return tile.types[type].first[pixel + 1] - tile.types[type].first[pixel];
}

uint32_t count_of(const SampleTile& tile, int pixel) {
  uint32_t sum = 0;
  for (size_t t = 0; t < tile.types.size(); ++t) sum += count_of(tile, t, pixel);
  return sum;
}

double coverage_of(const SampleTile& tile, int pixel) {
  double sum = 0;
  for (const TypedRows& rows : tile.types) {
    for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) sum += rows.weights[r];
  }
  return sum;
}

const float* row_of(const SampleTile& tile, const std::vector<SampleType>& types, size_t type,
                    uint32_t row) {
  return &tile.types[type].values[static_cast<size_t>(row) * types[type].width];
}

class Reduction : public testing::TestWithParam<std::tuple<ReductionMethod, int>> {
 protected:
  ReductionParams params() const {
    ReductionParams result;
    result.method = std::get<0>(GetParam());
    result.records = std::get<1>(GetParam());
    result.seed = 3;
    return result;
  }
  std::vector<SampleType> types_ = all_sample_types();
  SampleTile samples_ = make_random_tile(types_, 11, 9, 8, 4);
};

TEST_P(Reduction, KeepsCoverageCountsAndLayout) {
  const SampleTile records = reduce_tile(samples_, types_, params(), 100);
  EXPECT_EQ(records.width, samples_.width);
  EXPECT_EQ(records.height, samples_.height);
  ASSERT_EQ(records.types.size(), types_.size());
  for (size_t t = 0; t < types_.size(); ++t) {
    const TypedRows& rows = records.types[t];
    ASSERT_EQ(rows.first.size(), static_cast<size_t>(records.pixel_count()) + 1);
    ASSERT_EQ(rows.first.back(), rows.rows());
    ASSERT_EQ(rows.values.size(), rows.rows() * types_[t].width);
    for (const float weight : rows.weights) EXPECT_GT(weight, 0);
    for (const float value : rows.values) EXPECT_TRUE(is_finite(value));
  }
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    const uint32_t n = count_of(samples_, pixel);
    EXPECT_NEAR(coverage_of(records, pixel), coverage_of(samples_, pixel), 1e-6);
    EXPECT_LE(count_of(records, pixel), std::min<uint32_t>(n, params().records));
    EXPECT_EQ(count_of(records, pixel) == 0, n == 0);
  }
}

TEST_P(Reduction, GivesTypesTheirShare) {
  const bool strong = params().method == ReductionMethod::strong_kmeans;
  const SampleTile records = reduce_tile(samples_, types_, params(), 100);
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    std::vector<int> counts;
    for (size_t t = 0; t < types_.size(); ++t) {
      counts.push_back(static_cast<int>(count_of(samples_, t, pixel)));
    }
    const std::vector<int> share = allocate_records(counts, params().records, strong);
    for (size_t t = 0; t < types_.size(); ++t) {
      // Random vectors never coincide: strong k-means loses no cluster, the report's may.
      EXPECT_LE(count_of(records, t, pixel), static_cast<uint32_t>(share[t]));
      EXPECT_EQ(count_of(records, t, pixel) == 0, share[t] == 0);
    }
  }
}

TEST_P(Reduction, UnitFieldsStayUnitAndPositionsAreRealSamples) {
  const SampleTile records = reduce_tile(samples_, types_, params(), 100);
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    for (size_t t = 0; t < types_.size(); ++t) {
      for (uint32_t r = records.types[t].first[pixel]; r < records.types[t].first[pixel + 1]; ++r) {
        const float* v = row_of(records, types_, t, r);
        EXPECT_NEAR(glm::length(vec3(v[4], v[5], v[6])), 1, 1e-5);
        bool found = false;
        for (uint32_t s = samples_.types[t].first[pixel]; s < samples_.types[t].first[pixel + 1];
             ++s) {
          const float* sample = row_of(samples_, types_, t, s);
          found = found || std::equal(v, v + 4, sample);
        }
        EXPECT_TRUE(found) << "position and bias of pixel " << pixel;
      }
    }
  }
}

TEST_P(Reduction, DependsOnTheAbsolutePixelAlone) {
  const SampleTile records = reduce_tile(samples_, types_, params(), 100);
  const SampleTile again = reduce_tile(samples_, types_, params(), 100);
  // One pixel cut out as a tile of its own gives the same records.
  const int pixel = 60;
  SampleTile cut;
  cut.x0 = pixel % 11;
  cut.y0 = pixel / 11;
  cut.width = 1;
  cut.height = 1;
  for (size_t t = 0; t < types_.size(); ++t) {
    EXPECT_EQ(records.types[t].values, again.types[t].values);
    EXPECT_EQ(records.types[t].weights, again.types[t].weights);
    const TypedRows& rows = samples_.types[t];
    TypedRows& part = cut.types.emplace_back();
    for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) {
      const float* v = row_of(samples_, types_, t, r);
      part.values.insert(part.values.end(), v, v + types_[t].width);
      part.weights.push_back(rows.weights[r]);
    }
    part.first = {0, static_cast<uint32_t>(part.weights.size())};
  }
  const SampleTile alone = reduce_tile(cut, types_, params(), 100);
  for (size_t t = 0; t < types_.size(); ++t) {
    const TypedRows& rows = records.types[t];
    const auto begin = rows.values.begin() + std::ptrdiff_t{rows.first[pixel]} * types_[t].width;
    const auto end = rows.values.begin() + std::ptrdiff_t{rows.first[pixel + 1]} * types_[t].width;
    EXPECT_TRUE(std::equal(begin, end, alone.types[t].values.begin(), alone.types[t].values.end()));
  }
}

TEST_P(Reduction, MovedAndScaledScenesGiveTheSameRecords) {
  // By powers of two and whole numbers on a coarse grid: positions move without rounding.
  for (TypedRows& rows : samples_.types) {
    for (float& value : rows.values) {
      if (std::abs(value) <= 1) value = std::round(value * 32) / 32;
    }
  }
  for (const auto& [scale, offset] :
       {std::pair{0x1p-20f, 0.0f}, {0x1p20f, 0.0f}, {1.0f, 131072.0f}}) {
    // The report's k-means works in raw units: only a move leaves it alone.
    if (params().method == ReductionMethod::kmeans && scale != 1) continue;
    SampleTile moved = samples_;
    for (size_t t = 0; t < types_.size(); ++t) {
      for (size_t row = 0; row < moved.types[t].rows(); ++row) {
        float* v = &moved.types[t].values[row * types_[t].width];
        for (int c = 0; c < 3; ++c) v[c] = v[c] * scale + offset;
      }
    }
    ReductionParams scaled = params();
    scaled.scene_radius *= scale;
    const SampleTile expected = reduce_tile(samples_, types_, params(), 100);
    const SampleTile records = reduce_tile(moved, types_, scaled, 100);
    for (size_t t = 0; t < types_.size(); ++t) {
      EXPECT_EQ(records.types[t].first, expected.types[t].first);
      ASSERT_EQ(records.types[t].weights, expected.types[t].weights) << scale << " " << offset;
      for (size_t row = 0; row < records.types[t].rows(); ++row) {
        const float* a = row_of(records, types_, t, static_cast<uint32_t>(row));
        const float* b = row_of(expected, types_, t, static_cast<uint32_t>(row));
        for (int c = 0; c < 3; ++c) EXPECT_EQ(a[c], b[c] * scale + offset);
        for (int c = 4; c < types_[t].width; ++c) EXPECT_EQ(a[c], b[c]);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MethodsAndK, Reduction,
                         testing::Combine(testing::Values(ReductionMethod::kmeans,
                                                          ReductionMethod::strong_kmeans),
                                          testing::Values(1, 2, 4, 8, 16, 64)));

/// Largest difference, over pixels, between the mean of the records and that of the samples of
/// type `t`, in the first component of its colours.
double largest_mean_difference(const SampleTile& records, const SampleTile& samples,
                               const std::vector<SampleType>& types, size_t t) {
  const auto mean = [&](const SampleTile& tile, int pixel, int component) {
    double sum = 0;
    double weight = 0;
    for (uint32_t r = tile.types[t].first[pixel]; r < tile.types[t].first[pixel + 1]; ++r) {
      const double w = tile.types[t].weights[r];
      sum += w * row_of(tile, types, t, r)[component];
      weight += w;
    }
    return sum / weight;
  };
  double largest = 0;
  for (int pixel = 0; pixel < records.pixel_count(); ++pixel) {
    if (count_of(records, t, pixel) == 0) continue;  // a type that was lost
    for (size_t i = 0; i < types[t].field_count(); ++i) {
      if (types[t].field(i).kind != FieldKind::linear) continue;
      const int component = types[t].offsets[i];
      largest = std::max(
          largest, std::abs(mean(records, pixel, component) - mean(samples, pixel, component)));
    }
  }
  return largest;
}

TEST(ReductionMean, OfRecordsIsThatOfTheSamples) {
  std::vector<SampleType> types = all_sample_types();
  const SampleTile samples = make_random_tile(types, 11, 9, 8, 4);
  for (const ReductionMethod method : {ReductionMethod::kmeans, ReductionMethod::strong_kmeans,
                                       ReductionMethod::kmedoids, ReductionMethod::cmeans}) {
    ReductionParams params;
    params.method = method;
    params.records = 9;
    for (size_t t = 0; t < types.size(); ++t) {
      const SampleTile records = reduce_tile(samples, types, params, 100);
      EXPECT_LT(largest_mean_difference(records, samples, types, t), 1e-5)
          << label_of(reduction_method_labels, method) << " " << types[t].name;
    }
    // Representatives keep no mean: the test sees that.
    std::vector<SampleType> chosen = types;
    for (Merge& merge : chosen[0].merges) merge = Merge::representative;
    const SampleTile records = reduce_tile(samples, chosen, params, 100);
    EXPECT_GT(largest_mean_difference(records, samples, chosen, 0), 0.05);
  }
}

TEST(ReductionBaseline, AllAndPureKeepEverySample) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile samples = make_random_tile(types, 5, 5, 4, 1);
  for (const ReductionMethod method : {ReductionMethod::all, ReductionMethod::pure}) {
    ReductionParams params;
    params.method = method;
    params.records = 1;
    const SampleTile records = reduce_tile(samples, types, params, 5);
    for (size_t t = 0; t < types.size(); ++t) {
      EXPECT_EQ(records.types[t].values, samples.types[t].values);
      EXPECT_EQ(records.types[t].weights, samples.types[t].weights);
    }
  }
}

/// One pixel with the given phong and lambert rows.
SampleTile one_pixel(const std::vector<SampleType>& types, const std::vector<int>& counts,
                     float weight, uint64_t seed) {
  SampleTile tile;
  tile.width = 1;
  tile.height = 1;
  Random random(seed, RandomStream::tests, 0);
  for (size_t t = 0; t < types.size(); ++t) {
    TypedRows& rows = tile.types.emplace_back();
    for (int i = 0; i < counts[t]; ++i) {
      test::append_random_vector(types[t], random, rows.values);
      rows.weights.push_back(weight);
    }
    rows.first = {0, static_cast<uint32_t>(counts[t])};
  }
  return tile;
}

class FewSamples : public testing::TestWithParam<ReductionMethod> {
 protected:
  SampleTile reduce(const SampleTile& tile, int k) const {
    ReductionParams params;
    params.method = GetParam();
    params.records = k;
    return reduce_tile(tile, types_, params, 1);
  }
  std::vector<SampleType> types_ = {make_sample_type(Phong::info), make_sample_type(Lambert::info)};
};

TEST_P(FewSamples, KAtLeastNReturnsTheSamples) {
  const SampleTile tile = one_pixel(types_, {5, 3}, 0.04f, 1);
  for (const int k : {8, 9, 64}) {
    const SampleTile records = reduce(tile, k);
    for (size_t t = 0; t < 2; ++t) {
      EXPECT_EQ(records.types[t].values, tile.types[t].values);
      for (const float weight : records.types[t].weights) EXPECT_NEAR(weight, 0.04f, 1e-8);
    }
  }
}

TEST_P(FewSamples, OneSampleIsItsRecord) {
  const SampleTile tile = one_pixel(types_, {0, 1}, 0.04f, 2);
  for (const int k : {1, 8}) {
    const SampleTile records = reduce(tile, k);
    EXPECT_EQ(records.types[1].values, tile.types[1].values);
    EXPECT_EQ(records.types[1].weights, std::vector<float>{0.04f});
    EXPECT_EQ(records.types[0].rows(), 0u);
  }
}

TEST_P(FewSamples, NoSampleIsNoRecord) {
  EXPECT_EQ(reduce(one_pixel(types_, {0, 0}, 0.04f, 2), 4).row_count(), 0u);
}

TEST_P(FewSamples, TwoTypesWithOneSampleEach) {
  const SampleTile tile = one_pixel(types_, {1, 1}, 0.25f, 3);
  const SampleTile two = reduce(tile, 2);
  EXPECT_EQ(two.types[0].values, tile.types[0].values);
  EXPECT_EQ(two.types[1].values, tile.types[1].values);
  // Eq. 3: the lost type's share goes to the records that are left.
  const SampleTile one = reduce(tile, 1);
  EXPECT_EQ(one.types[0].rows(), 1u);
  EXPECT_EQ(one.types[1].rows(), 0u);
  EXPECT_FLOAT_EQ(one.types[0].weights[0], 0.5f);
}

TEST_P(FewSamples, LostTypesScaleTheOthersUp) {
  // 24 and 1 samples at k = 8: 8 and 0 for the report's k-means, 7 and 1 with one record a type.
  const SampleTile records = reduce(one_pixel(types_, {24, 1}, 0.04f, 4), 8);
  const bool strong = GetParam() == ReductionMethod::strong_kmeans;
  EXPECT_EQ(records.types[1].rows(), strong ? 1u : 0u);
  EXPECT_NEAR(coverage_of(records, 0), 1, 1e-6);
  const float unit = strong ? 0.04f : 1.0f / 24;
  for (const float weight : records.types[0].weights) {
    EXPECT_NEAR(weight / unit, std::round(weight / unit), 1e-4) << "a whole number of samples";
  }
}

TEST_P(FewSamples, EqualSamplesAreOneRecordOfFullWeight) {
  SampleTile tile = one_pixel(types_, {12, 0}, 0.0625f, 5);
  for (int row = 1; row < 12; ++row) {
    std::copy_n(tile.types[0].values.begin(), 14, tile.types[0].values.begin() + row * 14);
  }
  const SampleTile records = reduce(tile, 4);
  ASSERT_EQ(records.types[0].rows(), 1u);
  EXPECT_FLOAT_EQ(records.types[0].weights[0], 0.75f);
  for (int i = 0; i < 14; ++i) {
    EXPECT_NEAR(records.types[0].values[i], tile.types[0].values[i],
                1e-6f * (1 + std::abs(tile.types[0].values[i])));
  }
}

TEST_P(FewSamples, ZeroVectorsStayFinite) {
  SampleTile tile = one_pixel(types_, {9, 9}, 0.05f, 6);
  for (TypedRows& rows : tile.types) std::fill(rows.values.begin(), rows.values.end(), 0.0f);
  const SampleTile records = reduce(tile, 4);
  EXPECT_NEAR(coverage_of(records, 0), 0.9, 1e-6);
  for (const TypedRows& rows : records.types) {
    for (const float value : rows.values) EXPECT_EQ(value, 0);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, FewSamples,
                         testing::Values(ReductionMethod::kmeans, ReductionMethod::strong_kmeans));

TEST(ReportKmeans, IsKmeansOnRawFieldsFromTheFirstSamples) {
  const std::vector<SampleType> types = {make_sample_type(Phong::info)};
  const SampleTile tile = one_pixel(types, {25}, 0.04f, 7);
  ReductionParams params;
  params.method = ReductionMethod::kmeans;
  params.records = 4;
  const SampleTile records = reduce_tile(tile, types, params, 1);
  Features features;
  make_raw_features({&types[0], tile.types[0].values.data(), 25}, features);
  const Clustering clustering = kmeans(features, std::vector<int>{0, 1, 2, 3}, 100);
  ASSERT_EQ(records.types[0].rows(), static_cast<size_t>(clustering.count()));
  for (int cluster = 0; cluster < clustering.count(); ++cluster) {
    const float* v = row_of(records, types, 0, static_cast<uint32_t>(cluster));
    const float* representative = &tile.types[0].values[clustering.representatives[cluster] * 14];
    EXPECT_EQ(vec3(v[0], v[1], v[2]),
              vec3(representative[0], representative[1], representative[2]));
    const auto members =
        std::count(clustering.cluster_of.begin(), clustering.cluster_of.end(), cluster);
    EXPECT_NEAR(records.types[0].weights[cluster], 0.04 * static_cast<double>(members), 1e-7);
  }
}

TEST(ReportKmeans, IgnoresSeedAndSceneRadius) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 6, 6, 8, 9);
  ReductionParams params;
  params.method = ReductionMethod::kmeans;
  params.records = 4;
  const SampleTile first = reduce_tile(tile, types, params, 6);
  params.seed = 99;
  params.scene_radius = 1000;
  const SampleTile second = reduce_tile(tile, types, params, 6);
  for (size_t t = 0; t < types.size(); ++t)
    EXPECT_EQ(first.types[t].values, second.types[t].values);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include "reduction/reduction.h"
#include "reduction/training.h"
#include "tests/support/records.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

constexpr vec3 eye{0, 0, 5};

class Footprints : public testing::TestWithParam<ReductionMethod> {
 protected:
  std::vector<SampleType> types_ = all_sample_types();
  SampleTile samples_ = make_random_tile(types_, 6, 5, 6, 3);

  SampleTile reduce(int stored_members) const {
    Light low;
    low.position = {-5, 2, -5};
    Light high;
    high.position = {5, 6, 5};
    const std::vector<Light> lights = make_training_lights(low, high, {.lights = 12});
    const TrainingSet training = make_training_set(lights, types_, eye, 1);
    ReductionParams params;
    params.method = GetParam();
    params.records = 4;
    params.stored_members = stored_members;
    return reduce_tile(samples_, types_, params, 6, {&training, &training});
  }
};

/// Count, sum and sum of squares of positions.
struct Moments {
  double count = 0;
  dvec3 sum{0};
  dvec3 squares{0};

  void add(dvec3 mean, dvec3 variance, double n) {
    count += n;
    sum += n * mean;
    squares += n * (variance + mean * mean);
  }
};

Moments moments_of_samples(const SampleTile& tile, std::span<const SampleType> types, int pixel) {
  Moments moments;
  for (size_t t = 0; t < types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) {
      const float* v = &rows.values[size_t{r} * types[t].width];
      moments.add(dvec3(v[0], v[1], v[2]), dvec3(0), 1);
    }
  }
  return moments;
}

Moments moments_of_records(const SampleTile& tile, std::span<const SampleType> types, int pixel) {
  Moments moments;
  for (size_t t = 0; t < types.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) {
      const float* v = &rows.values[size_t{r} * types[t].width];
      const Footprint& f = rows.footprints[r];
      moments.add(dvec3(v[0], v[1], v[2]) + dvec3(f.offset),
                  dvec3(f.covariance[0], f.covariance[3], f.covariance[5]), f.samples);
    }
  }
  return moments;
}

TEST_P(Footprints, TogetherHaveTheMomentsOfAllSamples) {
  const SampleTile records = reduce(0);
  ASSERT_TRUE(records.has_footprints);
  // These lose a pixel's rarer types, so that not every sample has a record.
  const bool keeps_types = !is_report_method(GetParam());
  int compared = 0;
  for (int pixel = 0; pixel < samples_.pixel_count(); ++pixel) {
    const Moments expected = moments_of_samples(samples_, types_, pixel);
    const Moments found = moments_of_records(records, types_, pixel);
    EXPECT_LE(found.count, expected.count);
    if (found.count < expected.count) {
      // A fuzzy record may have no sample of its own; it counts as one where it stands.
      continue;
    }
    ++compared;
    for (size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(found.sum[axis], expected.sum[axis], 1e-5) << "pixel " << pixel;
      EXPECT_NEAR(found.squares[axis], expected.squares[axis], 1e-5) << "pixel " << pixel;
    }
  }
  EXPECT_GE(compared, keeps_types ? 5 : 1);
}

TEST_P(Footprints, AreParallelToTheRecords) {
  const SampleTile records = reduce(3);
  EXPECT_TRUE(records.has_members);
  size_t extended = 0;
  for (const TypedRows& rows : records.types) {
    ASSERT_EQ(rows.footprints.size(), rows.rows());
    size_t members = 0;
    for (const Footprint& footprint : rows.footprints) {
      const float trace =
          footprint.covariance[0] + footprint.covariance[3] + footprint.covariance[5];
      EXPECT_EQ(footprint.stored_members,
                footprint.samples < 2 ? 0 : std::min(3, footprint.samples));
      EXPECT_EQ(trace > 0, footprint.samples > 1);
      members += static_cast<size_t>(footprint.stored_members);
      extended += footprint.samples > 1 ? 1 : 0;
    }
    EXPECT_EQ(rows.members.size(), members);
    for (const Member& member : rows.members) {
      const float length = glm::length(member.normal);
      EXPECT_TRUE(length == 0 || std::abs(length - 1) < 1e-5f);
    }
  }
  EXPECT_GT(extended, 20u);
}

TEST(FootprintsOfSamples, AreLeftOut) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 4, 4, 2, 1);
  ReductionParams params;
  params.method = ReductionMethod::all;
  EXPECT_FALSE(reduce_tile(tile, types, params, 4).has_footprints);
}

INSTANTIATE_TEST_SUITE_P(
    Methods, Footprints,
    testing::Values(ReductionMethod::kmeans, ReductionMethod::strong_kmeans,
                    ReductionMethod::kmedoids, ReductionMethod::cmeans,
                    ReductionMethod::light_metric_1, ReductionMethod::light_metric_2,
                    ReductionMethod::light_metric_3, ReductionMethod::light_metric_4,
                    ReductionMethod::light_metric_5, ReductionMethod::light_metric_6,
                    ReductionMethod::light_fit_fast, ReductionMethod::light_fit),
    [](const auto& param) {
      std::string name(label_of(reduction_method_labels, param.param));
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

}  // namespace
}  // namespace relume

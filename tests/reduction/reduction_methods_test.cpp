// What every reduction method must hold, through reduce_tile, and the extremes of its input.

#include <gtest/gtest.h>

#include "core/shade/shader_list.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "tests/support/records.h"

namespace relume {
namespace {

constexpr float sample_weight = 1.0f / 25;

/// Types, lights and an eye for tiles of any samples.
struct Setting {
  std::vector<SampleType> types = test::all_sample_types();
  std::vector<Light> lights;
  vec3 eye{0, 0, 6};
  float radius = 1;

  Setting() {
    Light low;
    low.position = {-5, 2, -5};
    low.gain = 20;
    Light high = low;
    high.position = {5, 6, 5};
    high.gain = 40;
    lights = make_training_lights(low, high, {.lights = 24});
  }

  ReductionParams params(ReductionMethod method, int k) const {
    ReductionParams params;
    params.method = method;
    params.records = k;
    params.seed = 5;
    params.scene_radius = radius;
    return params;
  }
  SampleTile reduce(const SampleTile& tile, const ReductionParams& params) const {
    const TrainingSet training = make_training_set(lights, types, eye, radius);
    const TrainingSet validation = make_training_set(lights, types, eye, radius);
    return reduce_tile(tile, types, params, 50, {&training, &validation});
  }
};

double coverage_of(const SampleTile& tile, int pixel) {
  double sum = 0;
  for (const TypedRows& rows : tile.types) {
    for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r) sum += rows.weights[r];
  }
  return sum;
}

int count_of(const SampleTile& tile, int pixel) {
  uint32_t sum = 0;
  for (const TypedRows& rows : tile.types) sum += rows.first[pixel + 1] - rows.first[pixel];
  return static_cast<int>(sum);
}

/// Weights positive, all finite, directions of unit length where the samples' are.
void expect_sound_rows(const SampleTile& records, bool unit) {
  for (size_t t = 0; t < records.types.size(); ++t) {
    const TypedRows& rows = records.types[t];
    for (const float weight : rows.weights) ASSERT_GT(weight, 0);
    for (const float value : rows.values) ASSERT_TRUE(is_finite(value));
    const size_t width = rows.rows() == 0 ? 0 : rows.values.size() / rows.rows();
    for (size_t r = 0; unit && r < rows.rows(); ++r) {
      const float* v = &rows.values[r * width];
      ASSERT_NEAR(glm::length(vec3(v[4], v[5], v[6])), 1, 1e-5);
    }
  }
}

/// Weights sum to coverage, at most k records, each sound.
void expect_sound(const SampleTile& samples, const SampleTile& records, int k, bool unit = true) {
  ASSERT_EQ(records.types.size(), samples.types.size());
  for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    ASSERT_NEAR(coverage_of(records, pixel), coverage_of(samples, pixel), 1e-5)
        << "pixel " << pixel;
    ASSERT_LE(count_of(records, pixel), k);
    ASSERT_EQ(count_of(records, pixel) == 0, count_of(samples, pixel) == 0);
  }
  expect_sound_rows(records, unit);
}

/// Every pixel has a finite predicted error >= 0; without a budget also all that expect_sound asks
/// for; with one it may be without records, and its coverage is stored.
void expect_sound_prediction(const SampleTile& samples, const SampleTile& records,
                             const ReductionParams& params, bool unit) {
  const auto pixels = static_cast<size_t>(samples.pixel_count());
  ASSERT_EQ(records.predicted_error.size(), pixels);
  for (const float error : records.predicted_error) {
    ASSERT_TRUE(is_finite(error));
    ASSERT_GE(error, 0);
  }
  if (!(params.record_cost > 0)) {
    ASSERT_TRUE(records.coverage.empty());
    expect_sound(samples, records, params.records, unit);
    return;
  }
  ASSERT_EQ(records.coverage.size(), pixels);
  for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
    ASSERT_NEAR(records.coverage[pixel], coverage_of(samples, pixel), 1e-6);
    ASSERT_LE(count_of(records, pixel), params.records);
    if (count_of(records, pixel) > 0) {
      ASSERT_NEAR(coverage_of(records, pixel), records.coverage[pixel], 1e-5);
    }
  }
  expect_sound_rows(records, unit);
}

bool is_tested_under_budgets(ReductionMethod method) {
  return method == ReductionMethod::kmeans || method == ReductionMethod::strong_kmeans ||
         is_light_fit(method);
}

class EveryMethod : public testing::TestWithParam<ReductionMethod> {
 protected:
  SampleTile reduce(const SampleTile& tile, int k) const {
    return setting_.reduce(tile, setting_.params(GetParam(), k));
  }
  void expect_sound_for_all_k(const SampleTile& tile, bool unit = true) const {
    for (const int k : {1, 2, 4, 8, 16, 64}) {
      SCOPED_TRACE(testing::Message() << "k " << k);
      expect_sound(tile, reduce(tile, k), k, unit);
    }
    if (is_tested_under_budgets(GetParam())) expect_sound_predictions(tile, unit);
  }
  void expect_sound_predictions(const SampleTile& tile, bool unit) const {
    for (const float cost : {0.0f, 1e-30f, 1e-3f, 0.1f, 1e30f}) {
      SCOPED_TRACE(testing::Message() << "record cost " << cost);
      ReductionParams params = setting_.params(GetParam(), 9);
      params.predict_error = true;
      params.record_cost = cost;
      expect_sound_prediction(tile, setting_.reduce(tile, params), params, unit);
    }
  }
  /// Up to 7 rows of each type in each pixel.
  SampleTile random_tile(uint64_t seed) const {
    return test::make_random_tile(setting_.types, 6, 5, 7, seed);
  }
  /// Calls body(first float of the row) for every row of a type.
  template <class Body>
  void for_each_row(SampleTile& tile, const Body& body) const {
    for (size_t t = 0; t < tile.types.size(); ++t) {
      const auto width = static_cast<size_t>(setting_.types[t].width);
      for (size_t r = 0; r < tile.types[t].rows(); ++r)
        body(&tile.types[t].values[r * width], width);
    }
  }
  Setting setting_;
};

TEST_P(EveryMethod, KeepsCoverageForRandomSamples) {
  for (uint64_t seed = 0; seed < 5; ++seed) expect_sound_for_all_k(random_tile(seed));
}

TEST_P(EveryMethod, KAtLeastNReturnsTheSamples) {
  const SampleTile tile = random_tile(1);
  const SampleTile records = reduce(tile, 64);
  for (size_t t = 0; t < tile.types.size(); ++t) {
    EXPECT_EQ(records.types[t].values, tile.types[t].values);
    for (size_t r = 0; r < tile.types[t].rows(); ++r) {
      EXPECT_NEAR(records.types[t].weights[r], tile.types[t].weights[r], 1e-7);
    }
  }
}

TEST_P(EveryMethod, APixelDependsOnItsOwnSamplesAlone) {
  const SampleTile tile = random_tile(2);
  const SampleTile records = reduce(tile, 4);
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    SampleTile alone;
    alone.x0 = pixel % tile.width;
    alone.y0 = pixel / tile.width;
    alone.width = alone.height = 1;
    std::vector<std::vector<float>> expected;
    for (size_t t = 0; t < tile.types.size(); ++t) {
      const auto width = static_cast<std::ptrdiff_t>(setting_.types[t].width);
      const auto cut = [&](const TypedRows& rows) {
        return std::vector<float>(rows.values.begin() + rows.first[pixel] * width,
                                  rows.values.begin() + rows.first[pixel + 1] * width);
      };
      const TypedRows& rows = tile.types[t];
      TypedRows& part = alone.types.emplace_back();
      part.values = cut(rows);
      part.weights.assign(rows.weights.begin() + rows.first[pixel],
                          rows.weights.begin() + rows.first[pixel + 1]);
      part.first = {0, static_cast<uint32_t>(part.weights.size())};
      expected.push_back(cut(records.types[t]));
    }
    const SampleTile result = reduce(alone, 4);
    for (size_t t = 0; t < tile.types.size(); ++t) {
      ASSERT_EQ(result.types[t].values, expected[t]) << "pixel " << pixel;
    }
  }
}

TEST_P(EveryMethod, AnchorsAreRealSamples) {
  const SampleTile tile = random_tile(3);
  const SampleTile records = reduce(tile, 3);
  for (size_t t = 0; t < tile.types.size(); ++t) {
    const auto width = static_cast<size_t>(setting_.types[t].width);
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      for (uint32_t r = records.types[t].first[pixel]; r < records.types[t].first[pixel + 1]; ++r) {
        bool found = false;
        for (uint32_t s = tile.types[t].first[pixel]; s < tile.types[t].first[pixel + 1]; ++s) {
          found = found || std::equal(&records.types[t].values[r * width],
                                      &records.types[t].values[r * width + 4],
                                      &tile.types[t].values[s * width]);
        }
        ASSERT_TRUE(found) << "pixel " << pixel;
      }
    }
  }
}

TEST_P(EveryMethod, NoSampleOneSampleAndTwoTypesOfOne) {
  SampleTile tile;
  tile.width = 3;
  tile.height = 1;
  Random random(3, RandomStream::tests, 0);
  for (size_t t = 0; t < setting_.types.size(); ++t) {
    TypedRows& rows = tile.types.emplace_back();
    // Pixel 0: nothing; 1: one sample of type 0; 2: one each of types 0 and 1.
    const uint32_t count = t == 0 ? 2 : t == 1 ? 1 : 0;
    for (uint32_t i = 0; i < count; ++i) {
      test::append_random_vector(setting_.types[t], random, rows.values);
      rows.weights.push_back(sample_weight);
    }
    rows.first = {0, 0, t == 0 ? 1u : 0u, count};
  }
  expect_sound_for_all_k(tile);
}

TEST_P(EveryMethod, EqualSamplesAreOneRecordOfFullWeight) {
  SampleTile tile;
  tile.width = tile.height = 1;
  Random random(3, RandomStream::tests, 0);
  for (size_t t = 0; t < setting_.types.size(); ++t) {
    TypedRows& rows = tile.types.emplace_back();
    std::vector<float> vector;
    test::append_random_vector(setting_.types[t], random, vector);
    const int count = t == 1 ? 20 : 0;
    for (int i = 0; i < count; ++i) {
      rows.values.insert(rows.values.end(), vector.begin(), vector.end());
      rows.weights.push_back(sample_weight);
    }
    rows.first = {0, static_cast<uint32_t>(count)};
  }
  const SampleTile records = reduce(tile, 4);
  ASSERT_EQ(records.row_count(), 1u);
  EXPECT_NEAR(records.types[1].weights[0], 20 * sample_weight, 1e-6);
  for (size_t i = 0; i < records.types[1].values.size(); ++i) {
    const float expected = tile.types[1].values[i];
    EXPECT_NEAR(records.types[1].values[i], expected, 1e-6f * (1 + std::abs(expected)));
  }
}

TEST_P(EveryMethod, SurvivesAllBlackResponses) {
  SampleTile tile = random_tile(4);
  for (Light& light : setting_.lights) light.color = vec3(0);
  expect_sound_for_all_k(tile);
  setting_ = Setting();
  for_each_row(tile, [](float* v, size_t width) {
    std::fill(v + 7, v + std::min<size_t>(13, width), 0.0f);
  });
  expect_sound_for_all_k(tile);
}

TEST_P(EveryMethod, SurvivesALightOnASample) {
  const SampleTile tile = random_tile(5);
  const float* v = tile.types[1].values.data();
  for (size_t i = 0; i < setting_.lights.size(); i += 2) {
    setting_.lights[i].position = vec3(v[0], v[1], v[2]);
  }
  expect_sound_for_all_k(tile);
  setting_.eye = vec3(v[0], v[1], v[2]);
  expect_sound_for_all_k(tile);
}

TEST_P(EveryMethod, SurvivesExtremeExponents) {
  for (const float exponent : {0.0f, 1e-6f, 1e4f}) {
    SampleTile tile = random_tile(6);
    for_each_row(tile, [&](float* v, size_t width) {
      if (width == 14) v[13] = exponent;
      if (width == 15) v[14] = exponent > 0 ? 1 / (1 + exponent) : 0;
    });
    expect_sound_for_all_k(tile);
  }
}

TEST_P(EveryMethod, SurvivesExtremeColors) {
  for (const float scale : {1e-30f, 1e6f, 1e15f}) {
    SampleTile tile = random_tile(7);
    for_each_row(tile, [&](float* v, size_t width) {
      for (size_t i = 7; i < std::min<size_t>(13, width); ++i) v[i] *= scale;
    });
    expect_sound_for_all_k(tile);
    for (Light& light : setting_.lights) light.gain = 1e20f;
    expect_sound_for_all_k(tile);
    setting_ = Setting();
  }
}

TEST_P(EveryMethod, SurvivesScaledAndMovedScenes) {
  for (const auto& [scale, offset] :
       {std::pair{1e-6f, 0.0f}, {1e6f, 0.0f}, {1.0f, 1e6f}, {1e-6f, 1e6f}}) {
    SampleTile tile = random_tile(8);
    for_each_row(tile, [&, s = scale, o = offset](float* v, size_t) {
      for (int c = 0; c < 3; ++c) v[c] = v[c] * s + o;
    });
    setting_ = Setting();
    setting_.radius = scale;
    setting_.eye = setting_.eye * scale + offset;
    for (Light& light : setting_.lights) light.position = light.position * scale + offset;
    expect_sound_for_all_k(tile);
  }
}

TEST_P(EveryMethod, SurvivesZeroDirections) {
  SampleTile tile = random_tile(9);
  for_each_row(tile, [](float* v, size_t) { v[4] = v[5] = v[6] = 0; });
  expect_sound_for_all_k(tile, false);
}

TEST_P(EveryMethod, TrainingIsAskedForWhereItIsNeeded) {
  const SampleTile tile = random_tile(1);
  const std::vector<SampleType>& types = setting_.types;
  ReductionParams params;
  params.method = GetParam();
  if (needs_training(GetParam())) {
    EXPECT_DEATH(reduce_tile(tile, types, params, 50), "needs training");
  } else {
    EXPECT_NO_THROW(reduce_tile(tile, types, params, 50));
  }
}

std::vector<ReductionMethod> reducing_methods() {
  std::vector<ReductionMethod> methods;
  for (const auto& row : reduction_method_labels) {
    const bool keeps_all = row.value == ReductionMethod::all || row.value == ReductionMethod::pure;
    if (!keeps_all) methods.push_back(row.value);
  }
  return methods;
}

std::string test_name(const testing::TestParamInfo<ReductionMethod>& info) {
  std::string name(label_of(reduction_method_labels, info.param));
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, testing::ValuesIn(reducing_methods()), test_name);

TEST(ReportFaithful, NamesTheReportsMethodsAndItsChoices) {
  int count = 0;
  for (const auto& row : reduction_method_labels) {
    if (!is_report_method(row.value)) continue;
    ++count;
    const ReductionParams params = report_faithful_params(row.value);
    EXPECT_EQ(params.method, row.value);
    EXPECT_EQ(params.records, 8);
    EXPECT_EQ(params.max_iterations, 100);
  }
  EXPECT_EQ(count, 8) << "PURE, K-means and six Light Metrics";
  EXPECT_DEATH(report_faithful_params(ReductionMethod::strong_kmeans), "is_report_method");
  EXPECT_EQ(value_of(reduction_preset_labels, "report-faithful"), ReductionPreset::report_faithful);
}

}  // namespace
}  // namespace relume

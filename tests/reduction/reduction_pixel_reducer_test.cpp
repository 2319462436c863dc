// One pixel at any k, its error curve and its share of a budget.

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/shade/reference.h"
#include "core/shade/shaders.h"
#include "reduction/pixel_reducer.h"
#include "reduction/training.h"
#include "tests/support/records.h"

namespace relume {
namespace {

constexpr vec3 eye(0, 0, 6);
constexpr int image_width = 50;

/// A tile of up to 6 random rows of each type a pixel, with highlights that lights can find.
SampleTile make_tile(const std::vector<SampleType>& types) {
  SampleTile tile = test::make_random_tile(types, 6, 4, 6, 11);
  test::widen_highlights(types, tile);
  for (size_t t = 0; t < types.size(); ++t) {
    const auto width = static_cast<size_t>(types[t].width);
    for (size_t i = 13; width == 14 && i < tile.types[t].values.size(); i += width) {
      tile.types[t].values[i] = std::max(tile.types[t].values[i], 2.0f);
    }
  }
  return tile;
}

/// Types, lights and a tile.
struct Setting {
  std::vector<SampleType> types = test::all_sample_types();
  SampleTile tile = make_tile(types);
  std::vector<Light> validation_lights = make_lights(24, 2);
  TrainingSet training = make_training_set(make_lights(48, 1), types, eye, 1);
  TrainingSet validation = make_training_set(validation_lights, types, eye, 1);

  ReductionLights lights() const { return {&training, &validation}; }
  uint64_t pixel_number(int index) const {
    return static_cast<uint64_t>(index / tile.width) * image_width + index % tile.width;
  }
  PixelReducer make_reducer(const ReductionParams& params) const {
    return {types, params, lights()};
  }
  void load(PixelReducer& reducer, int index) const {
    reducer.load(tile, index, pixel_number(index));
  }
  SampleTile reduce(const ReductionParams& params) const {
    return reduce_tile(tile, types, params, image_width, lights());
  }

  static std::vector<Light> make_lights(int count, uint64_t seed) {
    Light low;
    low.position = {-5, 2, -5};
    low.gain = 20;
    Light high = low;
    high.position = {5, 6, 5};
    high.gain = 40;
    Bounds scene;
    scene.extend(vec3(-0.5773503f));
    scene.extend(vec3(0.5773503f));
    return make_mixed_training_lights(low, high, scene, count, seed);
  }
};

ReductionParams make_params(ReductionMethod method, int records) {
  ReductionParams params;
  params.method = method;
  params.records = records;
  params.seed = 5;
  params.predict_error = true;
  return params;
}

/// Whether `records` are those of one pixel of a reduced tile, bit by bit.
void expect_same(const PixelRecords& records, const SampleTile& tile, int pixel) {
  ASSERT_EQ(records.size(), tile.types.size());
  for (size_t t = 0; t < records.size(); ++t) {
    const TypedRows& rows = tile.types[t];
    const size_t width = rows.rows() == 0 ? 0 : rows.values.size() / rows.rows();
    const auto cut = [&](const std::vector<float>& values, size_t floats) {
      return std::vector<float>(
          values.begin() + static_cast<std::ptrdiff_t>(rows.first[pixel] * floats),
          values.begin() + static_cast<std::ptrdiff_t>(rows.first[pixel + 1] * floats));
    };
    ASSERT_EQ(records[t].values, cut(rows.values, width)) << "type " << t;
    ASSERT_EQ(records[t].weights, cut(rows.weights, 1)) << "type " << t;
  }
}

void expect_same(const PixelRecords& a, const PixelRecords& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t t = 0; t < a.size(); ++t) {
    ASSERT_EQ(a[t].values, b[t].values) << "type " << t;
    ASSERT_EQ(a[t].weights, b[t].weights) << "type " << t;
  }
}

/// The k of every step of a full curve.
std::vector<int> steps_up_to(int most) {
  std::vector<int> steps;
  for (const int k : record_steps) {
    steps.push_back(std::min(k, most));
    if (k >= most) break;
  }
  return steps;
}

constexpr std::array budget_methods = {
    ReductionMethod::kmeans,         ReductionMethod::strong_kmeans,  ReductionMethod::kmedoids,
    ReductionMethod::light_metric_5, ReductionMethod::light_fit_fast, ReductionMethod::light_fit};

TEST(PixelReducer, ReducesAsTheTileDoesInAnyOrder) {
  const Setting setting;
  for (const auto& [method, label] : reduction_method_labels) {
    if (method == ReductionMethod::all || method == ReductionMethod::pure) continue;
    SCOPED_TRACE(label);
    const ReductionParams params = make_params(method, 64);
    PixelReducer reducer = setting.make_reducer(params);
    for (const int k : {5, 1, 64, 3}) {
      SCOPED_TRACE(k);
      const SampleTile expected = setting.reduce(make_params(method, k));
      PixelRecords records;
      for (int pixel = setting.tile.pixel_count(); pixel-- > 0;) {
        setting.load(reducer, pixel);
        reducer.reduce(k % 4 + 1, records);  // what came before leaves no trace
        const float error = reducer.reduce(k, records);
        ASSERT_EQ(error, expected.predicted_error[pixel]) << "pixel " << pixel;
        expect_same(records, expected, pixel);
      }
    }
  }
}

TEST(PixelReducer, CurveCoversAllSteps) {
  const Setting setting;
  for (const ReductionMethod method : budget_methods) {
    SCOPED_TRACE(label_of(reduction_method_labels, method));
    for (const int limit : {1, 7, 9, 64}) {
      const ReductionParams params = make_params(method, limit);
      PixelReducer reducer = setting.make_reducer(params);
      for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
        setting.load(reducer, pixel);
        const ErrorCurve curve = reducer.error_curve(0);
        const std::vector<int> steps = steps_up_to(std::min(limit, reducer.sample_count()));
        ASSERT_EQ(curve.errors.size(), steps.size()) << "limit " << limit << " pixel " << pixel;
        ASSERT_EQ(curve.records.size(), steps.size());
        EXPECT_EQ(curve.records[0], 0);
        EXPECT_GE(curve.errors[0], curve.value * 0.9999f) << "a root mean square and a mean";
        for (size_t i = 1; i < steps.size(); ++i) {
          PixelRecords records;
          ASSERT_EQ(curve.errors[i], reducer.reduce(steps[i], records));
          ASSERT_LE(curve.records[i], steps[i]);
        }
        if (limit == 64) {
          ASSERT_EQ(curve.errors.back(), 0) << "all its samples";
        }
      }
    }
  }
}

TEST(PixelReducer, StoppingEarlyNeverChangesTheChoice) {
  const Setting setting;
  int stopped = 0;
  for (const ReductionMethod method : budget_methods) {
    SCOPED_TRACE(label_of(reduction_method_labels, method));
    for (const float cost : {1e-4f, 1e-3f, 1e-2f, 0.05f, 0.3f}) {
      ReductionParams params = make_params(method, 16);
      params.record_cost = cost;
      PixelReducer reducer = setting.make_reducer(params);
      for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
        SCOPED_TRACE(testing::Message() << "cost " << cost << " pixel " << pixel);
        setting.load(reducer, pixel);
        const ErrorCurve whole = reducer.error_curve(0);
        const ErrorCurve part = reducer.error_curve(cost);
        ASSERT_LE(part.errors.size(), whole.errors.size());
        ASSERT_TRUE(std::equal(part.errors.begin(), part.errors.end(), whole.errors.begin()));
        ASSERT_EQ(part.value, whole.value);
        const size_t step = choose_step(whole, cost);
        ASSERT_EQ(choose_step(part, cost), step);
        stopped += part.errors.size() < whole.errors.size();

        PixelRecords expected(setting.types.size());
        const int most = std::min(16, reducer.sample_count());
        if (step > 0) reducer.reduce(steps_up_to(most)[step], expected);
        PixelRecords records;
        ASSERT_EQ(reducer.reduce_within_cost(records), whole.errors[step]);
        expect_same(records, expected);
      }
    }
  }
  EXPECT_GT(stopped, 100) << "nothing was tested";
}

TEST(PixelReducer, BudgetOfATileIsThatOfItsPixels) {
  const Setting setting;
  ReductionParams params = make_params(ReductionMethod::light_fit, 16);
  params.predict_error = false;
  params.record_cost = 0.02f;
  const SampleTile reduced = setting.reduce(params);
  ASSERT_EQ(reduced.predicted_error.size(), static_cast<size_t>(setting.tile.pixel_count()));
  ASSERT_EQ(reduced.coverage.size(), static_cast<size_t>(setting.tile.pixel_count()));
  PixelReducer reducer = setting.make_reducer(params);
  for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
    setting.load(reducer, pixel);
    PixelRecords records;
    EXPECT_EQ(reducer.reduce_within_cost(records), reduced.predicted_error[pixel]);
    EXPECT_EQ(reducer.coverage(), reduced.coverage[pixel]);
    expect_same(records, reduced, pixel);
  }
}

/// Eq. 7 for one pixel, its mean over lights, in double and from the shaders' references.
class DirectError {
 public:
  explicit DirectError(const Setting& setting) : setting_(setting) {}

  std::vector<dvec3> values(const std::vector<std::vector<float>>& rows_by_type,
                            const std::vector<std::vector<float>>& weights) const {
    std::vector<dvec3> sums(setting_.validation_lights.size(), dvec3(0));
    for (size_t t = 0; t < rows_by_type.size(); ++t) {
      const SampleType& type = setting_.types[t];
      for (size_t row = 0; row < weights[t].size(); ++row) {
        for (size_t j = 0; j < sums.size(); ++j) {
          const Light& light = setting_.validation_lights[j];
          sums[j] +=
              double{weights[t][row]} * dvec3(light.weight()) *
              reference_response(type, &rows_by_type[t][row * type.width], light, dvec3(eye), 1);
        }
      }
    }
    return sums;
  }

  std::vector<dvec3> values_of_samples(int pixel) const {
    std::vector<std::vector<float>> rows;
    std::vector<std::vector<float>> weights;
    for (size_t t = 0; t < setting_.types.size(); ++t) {
      const TypedRows& all = setting_.tile.types[t];
      const auto width = static_cast<std::ptrdiff_t>(setting_.types[t].width);
      const std::ptrdiff_t first = all.first[pixel];
      const std::ptrdiff_t last = all.first[pixel + 1];
      rows.emplace_back(all.values.begin() + first * width, all.values.begin() + last * width);
      weights.emplace_back(all.weights.begin() + first, all.weights.begin() + last);
    }
    return values(rows, weights);
  }

  std::vector<dvec3> values_of_records(const PixelRecords& records) const {
    std::vector<std::vector<float>> rows;
    std::vector<std::vector<float>> weights;
    for (const TypedRows& typed : records) {
      rows.push_back(typed.values);
      weights.push_back(typed.weights);
    }
    return values(rows, weights);
  }

  static double error(const std::vector<dvec3>& a, const std::vector<dvec3>& b) {
    double sum = 0;
    for (size_t j = 0; j < a.size(); ++j) sum += glm::length(a[j] - b[j]) / std::sqrt(3.0);
    return sum / static_cast<double>(a.size());
  }

 private:
  const Setting& setting_;
};

TEST(PixelReducer, PredictedErrorIsEquation7InDouble) {
  const Setting setting;
  const DirectError direct(setting);
  for (const ReductionMethod method : budget_methods) {
    const ReductionParams params = make_params(method, 16);
    PixelReducer reducer = setting.make_reducer(params);
    for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
      setting.load(reducer, pixel);
      const std::vector<dvec3> expected = direct.values_of_samples(pixel);
      double value = 0;
      for (const dvec3& v : expected) value += (v.x + v.y + v.z) / 3;
      value /= static_cast<double>(expected.size());
      EXPECT_NEAR(reducer.error_curve(0).value, value, 1e-3 * value);
      for (const int k : {1, 3, 8}) {
        PixelRecords records;
        const double predicted = reducer.reduce(k, records);
        const double error = direct.error(direct.values_of_records(records), expected);
        ASSERT_NEAR(predicted, error, 1e-3 * value)
            << label_of(reduction_method_labels, method) << " pixel " << pixel << " k " << k;
      }
    }
  }
}

TEST(PixelReducer, LightFitIsNeverWorseThanStrongKmeans) {
  const Setting setting;
  for (const ReductionMethod method :
       {ReductionMethod::light_fit_fast, ReductionMethod::light_fit}) {
    double fitted_sum = 0;
    double plain_sum = 0;
    for (const int k : {1, 2, 4, 8, 12}) {
      const SampleTile plain = setting.reduce(make_params(ReductionMethod::strong_kmeans, k));
      const SampleTile fitted = setting.reduce(make_params(method, k));
      for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
        ASSERT_LE(fitted.predicted_error[pixel], plain.predicted_error[pixel])
            << "k " << k << " pixel " << pixel;
        fitted_sum += double{fitted.predicted_error[pixel]};
        plain_sum += double{plain.predicted_error[pixel]};
      }
    }
    EXPECT_LT(fitted_sum, 0.7 * plain_sum);
  }
}

TEST(PixelReducer, MoreRecordsHelpLightFitOnAverage) {
  const Setting setting;
  const ReductionParams params = make_params(ReductionMethod::light_fit, 16);
  PixelReducer reducer = setting.make_reducer(params);
  std::vector<double> sums(steps_up_to(16).size(), 0.0);
  for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
    setting.load(reducer, pixel);
    const std::vector<float> errors = reducer.error_curve(0).errors;
    for (size_t i = 0; i < errors.size(); ++i) sums[i] += double{errors[i]};
  }
  for (size_t i = 1; i < sums.size(); ++i) {
    EXPECT_LT(sums[i], sums[i - 1]) << "k " << record_steps[i];
  }
}

TEST(PixelReducer, ReportsSamplesAndCoverage) {
  const Setting setting;
  const ReductionParams params = make_params(ReductionMethod::strong_kmeans, 4);
  PixelReducer reducer = setting.make_reducer(params);
  for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
    setting.load(reducer, pixel);
    int count = 0;
    double weight = 0;
    for (const TypedRows& rows : setting.tile.types) {
      for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row, ++count) {
        weight += double{rows.weights[row]};
      }
    }
    EXPECT_EQ(reducer.sample_count(), count);
    EXPECT_NEAR(reducer.coverage(), weight, 1e-6);
  }
}

TEST(PixelReducer, APixelWithoutSamplesHasNoRecordsAndNoError) {
  Setting setting;
  setting.tile.width = setting.tile.height = 1;
  for (TypedRows& rows : setting.tile.types) {
    rows = TypedRows();
    rows.first = {0, 0};
  }
  for (const ReductionMethod method : budget_methods) {
    ReductionParams params = make_params(method, 8);
    params.record_cost = 1e-3f;
    PixelReducer reducer = setting.make_reducer(params);
    setting.load(reducer, 0);
    EXPECT_EQ(reducer.sample_count(), 0);
    EXPECT_EQ(reducer.coverage(), 0);
    PixelRecords records;
    EXPECT_EQ(reducer.reduce(4, records), 0);
    EXPECT_EQ(reducer.reduce_within_cost(records), 0);
    for (const TypedRows& rows : records) EXPECT_EQ(rows.rows(), 0u);
    const ErrorCurve curve = reducer.error_curve(0);
    EXPECT_EQ(curve.errors, std::vector<float>{0});
    EXPECT_EQ(curve.records, std::vector<int>{0});
    EXPECT_EQ(curve.value, 0);
  }
}

TEST(PixelReducer, RefusesWhatItCannotDo) {
  const Setting setting;
  const auto make = [&](ReductionMethod method, int records, const ReductionLights& lights) {
    const ReductionParams params = make_params(method, records);
    PixelReducer(setting.types, params, lights);
  };
  EXPECT_DEATH(make(ReductionMethod::all, 8, setting.lights()), "does not reduce");
  EXPECT_DEATH(make(ReductionMethod::pure, 8, setting.lights()), "does not reduce");
  EXPECT_DEATH(make(ReductionMethod::kmeans, 0, setting.lights()), "records 0");
  EXPECT_DEATH(make(ReductionMethod::light_fit, 8, {nullptr, &setting.validation}),
               "needs training");
  EXPECT_DEATH(make(ReductionMethod::light_fit, 8, {&setting.training, nullptr}),
               "needs validation");
  EXPECT_DEATH(make(ReductionMethod::kmeans, 8, {}), "needs validation");
  const ReductionParams params = make_params(ReductionMethod::strong_kmeans, 8);
  PixelReducer reducer = setting.make_reducer(params);
  setting.load(reducer, 0);
  PixelRecords records;
  EXPECT_DEATH(reducer.reduce(0, records), "k 0");
}

/// A type whose declared fields end before the normal: its records take all but the position from
/// one sample, and Light-Fit finds no direction to fit.
void hide_direction_of(SampleType& type) {
  type.merges.resize(2);
  type.offsets.resize(2);
}

TEST(PixelReducer, TypesThatCannotBeFittedKeepTheirOtherRecords) {
  Setting setting;
  const size_t last = setting.types.size() - 1;
  hide_direction_of(setting.types[last]);
  setting.training = make_training_set(Setting::make_lights(48, 1), setting.types, eye, 1);
  setting.validation = make_training_set(setting.validation_lights, setting.types, eye, 1);
  const LightFit fit(setting.training.evaluator, {});
  for (size_t t = 0; t < setting.types.size(); ++t) {
    EXPECT_EQ(fit.fits_type(static_cast<int>(t)), t != last);
  }
  for (const ReductionMethod method :
       {ReductionMethod::light_fit_fast, ReductionMethod::light_fit}) {
    int changed = 0;
    for (const int k : {1, 2, 5, 8}) {
      const SampleTile plain = setting.reduce(make_params(ReductionMethod::strong_kmeans, k));
      const SampleTile fitted = setting.reduce(make_params(method, k));
      EXPECT_EQ(fitted.types[last].values, plain.types[last].values);
      for (int pixel = 0; pixel < setting.tile.pixel_count(); ++pixel) {
        uint32_t count = 0;
        double weight = 0;
        double covered = 0;
        for (size_t t = 0; t < setting.types.size(); ++t) {
          const auto sum = [pixel](const TypedRows& rows) {
            return std::accumulate(rows.weights.begin() + rows.first[pixel],
                                   rows.weights.begin() + rows.first[pixel + 1], 0.0);
          };
          weight += sum(fitted.types[t]);
          covered += sum(setting.tile.types[t]);
          count += fitted.types[t].first[pixel + 1] - fitted.types[t].first[pixel];
        }
        ASSERT_NEAR(weight, covered, 1e-5) << "k " << k << " pixel " << pixel;
        ASSERT_LE(count, static_cast<uint32_t>(k));
        ASSERT_LE(fitted.predicted_error[pixel], plain.predicted_error[pixel]);
        changed += fitted.predicted_error[pixel] < plain.predicted_error[pixel];
      }
    }
    EXPECT_GT(changed, 40) << "the other types are fitted";
  }
}

}  // namespace
}  // namespace relume

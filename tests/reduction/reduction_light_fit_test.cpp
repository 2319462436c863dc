#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "core/shade/shaders.h"
#include "reduction/methods/cholesky.h"
#include "reduction/methods/light_fit.h"
#include "reduction/methods/light_fit_records.h"
#include "reduction/training.h"

namespace relume::test {
namespace {

constexpr vec3 eye(0, 0, 6);

/// A pixel of Phong and Lambert samples about two surfaces.
struct Pixel {
  std::vector<SampleType> types;
  std::vector<std::vector<float>> values;  ///< per type
  std::vector<SampleMatrix> matrices;

  explicit Pixel(int n, uint64_t seed) {
    for (const ShaderInfo* shader : shader_table()) types.push_back(make_sample_type(*shader));
    values.resize(types.size());
    Random random(seed, RandomStream::tests, 0);
    for (int i = 0; i < n; ++i) {
      const size_t t = i % 3 == 0 ? 0 : 1;  // lambert, phong
      std::vector<float> v(types[t].width);
      for (float& x : v) x = random.uniform(0.05f, 0.5f);
      const float x = random.uniform(-0.4f, 0.4f) + (i % 2 == 0 ? 0.5f : -0.5f);
      const vec3 normal = normalize_or(vec3(x, random.uniform(-0.4f, 0.4f), 1), vec3(0, 0, 1));
      for (int axis = 0; axis < 3; ++axis) v[4 + axis] = normal[axis];
      if (t == 1) v[13] = random.uniform(5, 30);
      values[t].insert(values[t].end(), v.begin(), v.end());
    }
    for (size_t t = 0; t < types.size(); ++t) {
      matrices.push_back(
          {&types[t], values[t].data(), static_cast<int>(values[t].size()) / types[t].width});
    }
  }
};

TrainingSet make_lights(const Pixel& pixel, uint64_t seed) {
  Light low;
  low.position = vec3(-4, -4, 1);
  low.gain = 20;
  Light high = low;
  high.position = vec3(4, 4, 5);
  Bounds scene;
  scene.extend(vec3(-1));
  scene.extend(vec3(1));
  return make_training_set(make_mixed_training_lights(low, high, scene, 64, seed), pixel.types, eye,
                           1);
}

std::vector<FittedRecord> run_fit(const Pixel& pixel, const TrainingSet& training, int n, int k,
                                  bool joint) {
  LightFit fit(training.evaluator, {.joint = joint});
  return fit.load(pixel.matrices, 1.0f / static_cast<float>(n)) ? fit.fit(k)
                                                                : std::vector<FittedRecord>();
}

/// TR2007-600 eq. 2 on the lights of `set`: the squared distance, over lights and RGB, between what
/// the records and the pixel's n samples look like.
double error_under(const Pixel& pixel, const TrainingSet& set,
                   const std::vector<FittedRecord>& records, int n) {
  const LobeEvaluator& evaluator = set.evaluator;
  PixelResponses responses;
  evaluate_responses(evaluator, pixel.matrices, 1.0f / static_cast<float>(n), responses);
  std::vector<double> difference(responses.target.begin(), responses.target.end());
  std::vector<float> lobes(static_cast<size_t>(max_lobes) * responses.columns);
  std::vector<float> values(difference.size());
  for (const FittedRecord& record : records) {
    evaluator.lobes(record.type, record.vector.data(), lobes.data());
    shade_rows(evaluator, record.type, record.vector.data(), 1, lobes.data(), values.data());
    for (size_t i = 0; i < values.size(); ++i) difference[i] -= double{record.weight} * values[i];
  }
  return std::inner_product(difference.begin(), difference.end(), difference.begin(), 0.0);
}

TEST(LightFit, JointPolishLowersTheTrainingError) {
  double fast = 0;
  double full = 0;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    const Pixel pixel(25, seed);
    const TrainingSet training = make_lights(pixel, 0);
    fast += error_under(pixel, training, run_fit(pixel, training, 25, 3, false), 25);
    full += error_under(pixel, training, run_fit(pixel, training, 25, 3, true), 25);
  }
  EXPECT_LT(full, 0.8 * fast);
}

TEST(LightFit, MoreRecordsLowerTheErrorOnHeldOutLights) {
  double previous = std::numeric_limits<double>::infinity();
  for (const int k : {1, 2, 4, 8}) {
    double error = 0;
    for (uint64_t seed = 0; seed < 20; ++seed) {
      const Pixel pixel(25, seed);
      const TrainingSet training = make_lights(pixel, 0);
      error +=
          error_under(pixel, make_lights(pixel, 99), run_fit(pixel, training, 25, k, true), 25);
    }
    EXPECT_LT(error, previous) << "k " << k;
    previous = error;
  }
}

TEST(LightFit, RecordsKeepWeightAnchorsAndBounds) {
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Pixel pixel(25, seed);
    const std::vector<FittedRecord> records = run_fit(pixel, make_lights(pixel, 0), 25, 5, true);
    ASSERT_FALSE(records.empty());
    double weight = 0;
    std::set<std::array<float, 3>> anchors;
    for (const SampleMatrix& matrix : pixel.matrices) {
      for (int row = 0; row < matrix.rows; ++row) {
        anchors.insert({matrix.row(row)[0], matrix.row(row)[1], matrix.row(row)[2]});
      }
    }
    for (const FittedRecord& record : records) {
      weight += record.weight;
      EXPECT_EQ(anchors.count({record.vector[0], record.vector[1], record.vector[2]}), 1u);
      EXPECT_NEAR(glm::length(vec3(record.vector[4], record.vector[5], record.vector[6])), 1, 1e-5);
      for (const float x : record.vector) EXPECT_TRUE(std::isfinite(x));
      for (int c = 7; c < 10; ++c) EXPECT_GE(record.vector[c], 0);
      if (record.type == 1) {
        EXPECT_GE(record.vector[13], 0.6f * 5);
        EXPECT_LE(record.vector[13], 1.5f * 30);
      }
    }
    EXPECT_NEAR(weight, 1, 1e-5);
  }
}

TEST(LightFit, SaysNothingWhenAllIsBlack) {
  Pixel pixel(10, 0);
  for (std::vector<float>& values : pixel.values) {
    for (size_t i = 0; i < values.size(); ++i) {
      // Colours to 0; positions and normals stay.
      const size_t width = pixel.values[0].data() == values.data() ? 10 : 14;
      if (i % width >= 7 && i % width < 13) values[i] = 0;
    }
  }
  const TrainingSet training = make_lights(pixel, 0);
  LightFit fit(training.evaluator, {});
  EXPECT_FALSE(fit.load(pixel.matrices, 0.1f));
}

/// What `records` show under the lights: 3 x columns a record.
std::vector<float> responses_of(const LobeEvaluator& evaluator,
                                const std::vector<FitRecord>& records) {
  const auto columns = static_cast<size_t>(evaluator.lights().columns());
  std::vector<float> out;
  std::vector<float> lobes(max_lobes * columns);
  for (const FitRecord& record : records) {
    std::fill(lobes.begin(), lobes.end(), 0.0f);
    evaluator.lobes(record.type, record.vector.data(), lobes.data());
    for (int c = 0; c < 3; ++c) {
      for (size_t j = 0; j < columns; ++j) {
        out.push_back(record.color[0][c] * lobes[j] + record.color[1][c] * lobes[columns + j]);
      }
    }
  }
  return out;
}

TEST(RecordFitter, FindsWhatTheTargetWasMadeOfInFewSteps) {
  const Pixel pixel(25, 0);
  const TrainingSet training = make_lights(pixel, 0);
  const LobeEvaluator& evaluator = training.evaluator;
  const std::vector<float> ones(static_cast<size_t>(evaluator.lights().columns()), 1.0f);
  for (uint64_t seed = 0; seed < 10; ++seed) {
    Random random(seed, RandomStream::tests, 1);
    std::vector<FitRecord> expected(2);
    for (size_t r = 0; r < 2; ++r) {
      FitRecord& record = expected[r];
      record.type = 1;  // phong
      record.vector.assign(pixel.values[1].begin(), pixel.values[1].begin() + 14);
      const vec3 normal =
          glm::normalize(vec3(r == 0 ? -0.6f : 0.6f, random.uniform(-0.3f, 0.3f), 1));
      std::copy_n(&normal.x, 3, &record.vector[4]);
      record.vector[13] = random.uniform(8, 20);
      record.scalar_low = 1;
      record.scalar_high = 100;
      for (int c = 0; c < 3; ++c) {
        for (int k = 0; k < max_lobes; ++k) {
          record.color[k][c] = random.uniform(0.2f, 0.8f);
          record.upper[k][c] = 2;
        }
      }
    }
    const std::vector<float> targets = responses_of(evaluator, expected);
    std::vector<FitRecord> records = expected;
    for (FitRecord& record : records) {
      const vec3 turned =
          glm::normalize(vec3(record.vector[4] + random.uniform(-0.15f, 0.15f),
                              record.vector[5] + random.uniform(-0.15f, 0.15f), record.vector[6]));
      std::copy_n(&turned.x, 3, &record.vector[4]);
      record.vector[13] *= random.uniform(0.8f, 1.2f);
      for (int c = 0; c < 3; ++c) {
        for (auto& lobe : record.color) lobe[c] *= random.uniform(0.7f, 1.3f);
      }
    }
    const auto error_of = [&] {
      const std::vector<float> found = responses_of(evaluator, records);
      double error = 0;
      double squares = 0;
      for (size_t i = 0; i < found.size(); ++i) {
        error += std::pow(double{found[i]} - targets[i], 2);
        squares += std::pow(double{targets[i]}, 2);
      }
      return error / squares;
    };
    ASSERT_GT(error_of(), 0.05) << seed;
    RecordFitter fitter(evaluator, ones);
    fitter.fit(records, targets, 0.1f, 0, 8);
    EXPECT_LT(error_of(), 1e-6) << seed;
  }
}

TEST(Cholesky, SolvesAndRefusesSingularMatrices) {
  std::vector<double> a = {4, 2, 2, 5};
  std::vector<double> x = {10, 13};  // a (1.5, 2) = (10, 13)
  ASSERT_TRUE(factor_cholesky(a, 2));
  forward_substitute(a, 2, x, 1);
  backward_substitute(a, 2, x, 1);
  EXPECT_NEAR(x[0], 1.5, 1e-12);
  EXPECT_NEAR(x[1], 2, 1e-12);
  std::vector<double> singular = {1, 1, 1, 1};
  EXPECT_FALSE(factor_cholesky(singular, 2));
}

}  // namespace
}  // namespace relume::test

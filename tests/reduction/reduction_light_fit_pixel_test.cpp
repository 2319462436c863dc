// What a sample costs in the cluster of another, against direct minimisation.

#include <gtest/gtest.h>

#include "reduction/methods/light_fit_pixel.h"
#include "reduction/training.h"
#include "tests/support/records.h"

namespace relume {
namespace {

constexpr vec3 eye(0, 0, 6);

/// Samples of one pixel, by type, in the order of the program's shaders.
struct Pixel {
  std::vector<SampleType> types = test::all_sample_types();
  std::vector<std::vector<float>> values{types.size()};

  void add(std::string_view shader, const std::vector<float>& vector) {
    for (size_t t = 0; t < types.size(); ++t) {
      if (types[t].shader->name != shader) continue;
      ASSERT_EQ(static_cast<int>(vector.size()), types[t].width);
      values[t].insert(values[t].end(), vector.begin(), vector.end());
    }
  }
  std::vector<SampleMatrix> matrices() const {
    std::vector<SampleMatrix> result;
    for (size_t t = 0; t < types.size(); ++t) {
      result.push_back(
          {&types[t], values[t].data(), static_cast<int>(values[t].size()) / types[t].width});
    }
    return result;
  }
};

Pixel make_random_pixel(int rows, uint64_t seed) {
  Pixel pixel;
  Random random(seed, RandomStream::tests, 0);
  for (size_t t = 0; t < pixel.types.size(); ++t) {
    for (int i = 0; i < rows; ++i) {
      std::vector<float> vector;
      test::append_random_vector(pixel.types[t], random, vector);
      test::widen_highlight(pixel.types[t], vector.data());
      pixel.values[t].insert(pixel.values[t].end(), vector.begin(), vector.end());
    }
  }
  return pixel;
}

/// Directional lights all around.
std::vector<Light> make_suns(int count) {
  std::vector<Light> lights;
  Random random(3, RandomStream::tests, 0);
  for (int i = 0; i < count; ++i) {
    Light light;
    light.type = LightType::directional;
    light.direction = test::random_direction(random);
    light.color = vec3(0.2f, 0.5f, 1);
    light.gain = 1 + static_cast<float>(i % 5);
    lights.push_back(light);
  }
  return lights;
}

/// Point lights, then directional ones, all around.
std::vector<Light> make_lights(int count) {
  std::vector<Light> lights = make_suns(count);
  for (int i = 0; i < count / 2; ++i) {
    lights[i].type = LightType::point;
    lights[i].position = lights[i].direction * 4.0f;
  }
  return lights;
}

/// A pixel made ready under lights that live as long as it does.
struct Loaded {
  Pixel pixel;  ///< the samples stay where they are
  TrainingSet training;
  FitPixel fit;
  bool is_loaded;

  Loaded(Pixel samples, const std::vector<Light>& lights)
      : pixel(std::move(samples)),
        training(make_training_set(lights, pixel.types, eye, 1)),
        fit(training.evaluator),
        is_loaded(fit.load(pixel.matrices(), 0.05f, std::vector<bool>(pixel.types.size(), true))) {}
};

double energy_of(const FitPixel& fit, int i) {
  double sum = 0;
  for (size_t x = 0; x < fit.length(); ++x)
    sum += double{fit.samples[i].v[x]} * fit.samples[i].v[x];
  return sum;
}

/// Least squares of one channel with colours >= 0 of up to two lobes, by trying every set of lobes
/// that are not 0: the squared residual.
double nonnegative_residual(const float* target, const float* lobes, size_t columns) {
  double a = 0;
  double b = 0;
  double d = 0;
  double r0 = 0;
  double r1 = 0;
  for (size_t j = 0; j < columns; ++j) {
    const double l0 = lobes[j];
    const double l1 = lobes[columns + j];
    a += l0 * l0;
    b += l0 * l1;
    d += l1 * l1;
    r0 += l0 * target[j];
    r1 += l1 * target[j];
  }
  const auto residual = [&](double x, double y) {
    double sum = 0;
    for (size_t j = 0; j < columns; ++j) {
      const double e = target[j] - x * lobes[j] - y * lobes[columns + j];
      sum += e * e;
    }
    return sum;
  };
  // A lobe that next to no light hits would need a colour beyond all bounds.
  const double faint = 1e-12 * std::max(a, d);
  double least = residual(0, 0);
  if (a > faint && r0 > 0) least = std::min(least, residual(r0 / a, 0));
  if (d > faint && r1 > 0) least = std::min(least, residual(0, r1 / d));
  const double determinant = a * d - b * b;
  if (a > faint && d > faint && determinant > 1e-12 * a * d) {
    const double x = (d * r0 - b * r1) / determinant;
    const double y = (a * r1 - b * r0) / determinant;
    if (x >= 0 && y >= 0) least = std::min(least, residual(x, y));
  }
  return least;
}

TEST(FitPixel, ScalesResponsesToOrderOneWhateverTheExposure) {
  const Pixel pixel = make_random_pixel(4, 1);
  for (const float gain : {1e-12f, 1.0f, 1e12f}) {
    std::vector<Light> lights = make_lights(40);
    for (Light& light : lights) light.gain *= gain;
    const Loaded loaded(pixel, lights);
    ASSERT_TRUE(loaded.is_loaded);
    ASSERT_EQ(loaded.fit.n(), 4 * static_cast<int>(pixel.types.size()));
    ASSERT_EQ(loaded.fit.length(), 3u * loaded.training.lights->columns());
    double squares = 0;
    for (size_t x = 0; x < loaded.fit.length(); ++x) {
      double sum = 0;
      for (const FitSample& sample : loaded.fit.samples) sum += double{0.05f} * sample.v[x];
      squares += sum * sum;
    }
    EXPECT_GT(squares, 0.3);
    EXPECT_LT(squares, 3);
  }
}

TEST(FitPixel, LeavesOutTypesThatAreNotFitted) {
  const Pixel pixel = make_random_pixel(3, 2);
  const TrainingSet training = make_training_set(make_lights(32), pixel.types, eye, 1);
  FitPixel fit(training.evaluator);
  ASSERT_TRUE(fit.load(pixel.matrices(), 0.1f, {true, false, true, false, false}));
  ASSERT_EQ(fit.n(), 6);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(fit.samples[i].type, i < 3 ? 0 : 2);
    EXPECT_EQ(fit.samples[i].vector, pixel.matrices()[i < 3 ? 0 : 2].row(i % 3));
  }
  EXPECT_FALSE(fit.load(pixel.matrices(), 0.1f, std::vector<bool>(pixel.types.size(), false)));
  EXPECT_EQ(fit.n(), 0);
}

TEST(FitPixel, UnexplainedEqualsBruteForce) {
  double largest = 0;
  for (uint64_t seed = 0; seed < 20; ++seed) {
    const Pixel pixel = make_random_pixel(5, seed);
    const Loaded loaded(pixel, make_lights(48));
    ASSERT_TRUE(loaded.is_loaded);
    const FitPixel& fit = loaded.fit;
    const std::vector<float> costs = fit.unexplained(0, 64).values;
    const auto columns = static_cast<size_t>(fit.columns);
    ASSERT_EQ(costs.size(), 25 * pixel.types.size() * pixel.types.size());
    for (int m = 0; m < fit.n(); ++m) {
      ASSERT_EQ(costs[m * fit.n() + m], 0);
      for (int i = 0; i < fit.n(); ++i) {
        if (i == m) continue;
        double expected = 0;
        for (size_t c = 0; c < 3; ++c) {
          expected +=
              nonnegative_residual(fit.samples[i].v + c * columns, fit.samples[m].lobes, columns);
        }
        const double energy = energy_of(fit, i);
        // In floats, two lobes that are nearly the same leave three digits.
        ASSERT_NEAR(costs[m * fit.n() + i], expected, 2e-3 * energy)
            << "seed " << seed << " record " << m << " sample " << i;
        largest = std::max(largest, expected / energy);
      }
    }
  }
  EXPECT_GT(largest, 0.5) << "some samples cannot stand for others";
}

TEST(FitPixel, SamplesThatDifferInColorAloneCostNothing) {
  Random random(4, RandomStream::tests, 0);
  Pixel pixel;
  for (int i = 0; i < 6; ++i) {
    std::vector<float> phong{0.1f, 0.2f, 0.3f, 1e-4f, 0.6f, 0, 0.8f};
    for (int c = 0; c < 6; ++c) phong.push_back(random.uniform());
    phong.push_back(12);
    pixel.add("phong", phong);
  }
  const Loaded loaded(pixel, make_lights(48));
  ASSERT_TRUE(loaded.is_loaded);
  const std::vector<float> costs = loaded.fit.unexplained(0.02f, 64).values;
  for (int m = 0; m < 6; ++m) {
    for (int i = 0; i < 6; ++i) {
      EXPECT_NEAR(costs[m * 6 + i], 0, 1e-5 * energy_of(loaded.fit, i));
    }
  }
}

TEST(FitPixel, PositionAddsItsShareOfTheEnergy) {
  // Under directional lights a Lambert sample looks the same wherever it is.
  Random random(5, RandomStream::tests, 0);
  Pixel pixel;
  std::vector<dvec3> positions;
  for (int i = 0; i < 7; ++i) {
    const vec3 p = test::random_direction(random) * random.uniform();
    positions.emplace_back(p);
    pixel.add("lambert", {p.x, p.y, p.z, 1e-4f, 0, 0.6f, 0.8f, random.uniform(), 0.5f, 0.1f});
  }
  const Loaded loaded(pixel, make_suns(48));
  ASSERT_TRUE(loaded.is_loaded);
  double mean_square = 0;
  for (const dvec3& a : positions) {
    for (const dvec3& b : positions) mean_square += glm::dot(a - b, a - b) / 49;
  }
  for (const float weight : {0.02f, 0.5f}) {
    const std::vector<float> costs = loaded.fit.unexplained(weight, 64).values;
    for (int m = 0; m < 7; ++m) {
      for (int i = 0; i < 7; ++i) {
        const dvec3 d = positions[m] - positions[i];
        const double energy = energy_of(loaded.fit, i);
        EXPECT_NEAR(costs[m * 7 + i], energy * weight * glm::dot(d, d) / mean_square,
                    1e-5 * energy);
      }
    }
  }
}

TEST(FitPixel, FlippedLeavesWithSwappedColorsAreTheSame) {
  const std::vector<float> front{0, 0, 0, 1e-4f, 0.6f, 0, 0.8f, 0.1f, 0.5f, 0.2f, 0.4f, 0.3f, 0};
  std::vector<float> back = front;
  for (int c = 0; c < 3; ++c) {
    back[4 + c] = -front[4 + c];
    back[7 + c] = front[10 + c];
    back[10 + c] = front[7 + c];
  }
  std::vector<float> turned = front;
  turned[4] = -0.6f;
  Pixel pixel;
  for (const std::vector<float>& leaf : {front, back, turned}) pixel.add("leaf", leaf);
  const Loaded loaded(pixel, make_lights(48));
  ASSERT_TRUE(loaded.is_loaded);
  const double energy = energy_of(loaded.fit, 0);
  ASSERT_NEAR(energy_of(loaded.fit, 1), energy, 1e-5 * energy);
  const std::vector<float> costs = loaded.fit.unexplained(0.02f, 64).values;
  EXPECT_NEAR(costs[0 * 3 + 1], 0, 1e-5 * energy);
  EXPECT_NEAR(costs[1 * 3 + 0], 0, 1e-5 * energy);
  EXPECT_GT(costs[0 * 3 + 2], 0.01 * energy) << "another normal is not";
}

TEST(FitPixel, CostsKnowWhoStandsForWhom) {
  // A Phong record can be all diffuse; a Lambert record has no highlight.
  Pixel pixel;
  pixel.add("lambert", {0, 0, 0, 1e-4f, 0, 0, 1, 0.5f, 0.5f, 0.5f});
  pixel.add("phong", {0, 0, 0, 1e-4f, 0, 0, 1, 0.1f, 0.1f, 0.1f, 0.5f, 0.5f, 0.5f, 20});
  const Loaded loaded(pixel, make_lights(64));
  ASSERT_TRUE(loaded.is_loaded);
  const std::vector<float> costs = loaded.fit.unexplained(0.02f, 64).values;
  EXPECT_NEAR(costs[1 * 2 + 0], 0, 1e-5 * energy_of(loaded.fit, 0));
  EXPECT_GT(costs[0 * 2 + 1], 0.3 * energy_of(loaded.fit, 1));
}

TEST(FitPixel, RefusesBlackAndInfiniteResponses) {
  Pixel pixel;
  pixel.add("lambert", {0, 0, 0, 1e-4f, 0, 0, 1, 0, 0, 0});
  EXPECT_FALSE(Loaded(pixel, make_lights(32)).is_loaded) << "black";
  pixel.values[0][7] = std::numeric_limits<float>::infinity();
  EXPECT_FALSE(Loaded(pixel, make_lights(32)).is_loaded) << "infinite";
}

}  // namespace
}  // namespace relume

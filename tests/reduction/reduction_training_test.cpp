#include <gtest/gtest.h>

#include <array>
#include <numeric>
#include <set>

#include "core/shade/reference.h"
#include "core/shade/shader_list.h"
#include "reduction/training.h"
#include "tests/support/records.h"

namespace relume {
namespace {

Light make_low() {
  Light low;
  low.name = "low";
  low.position = {-2, 1, -3};
  low.direction = {-1, -1, 0};
  low.color = {0.2f, 0.4f, 0.6f};
  low.gain = 10;
  return low;
}

Light make_high() {
  Light high = make_low();
  high.position = {4, 5, 6};
  high.direction = {1, -0.5f, 2};
  high.color = {1, 1, 1};
  high.gain = 30;
  return high;
}

bool within(vec3 low, vec3 value, vec3 high) {
  return glm::all(glm::lessThanEqual(low, value)) && glm::all(glm::lessThanEqual(value, high));
}

TEST(TrainingLights, LieInTheBoxOfTheRepresentatives) {
  const Light low = make_low();
  const Light high = make_high();
  const std::vector<Light> lights = make_training_lights(low, high, {.lights = 200});
  ASSERT_EQ(lights.size(), 200u);
  vec3 mean(0);
  double mixed = 0;
  for (const Light& light : lights) {
    EXPECT_TRUE(within(low.position, light.position, high.position));
    EXPECT_TRUE(within(low.color, light.color, high.color));
    EXPECT_GE(light.gain, low.gain);
    EXPECT_LE(light.gain, high.gain);
    mean += light.position / 200.0f;
    // Each parameter by itself, a box: along a segment x and y would be proportional.
    const vec3 t = (light.position - low.position) / (high.position - low.position);
    mixed += std::abs(t.x - t.y) / 200.0;
  }
  EXPECT_LT(glm::distance(mean, vec3(1, 3, 1.5f)), 0.7f);
  EXPECT_NEAR(mixed, 1.0 / 3, 0.07);
}

TEST(TrainingLights, AreTheSameForASeedAndNeverThoseOfLowIndices) {
  const Light low = make_low();
  const Light high = make_high();
  const std::vector<Light> lights = make_training_lights(low, high, {.lights = 50, .seed = 4});
  const std::vector<Light> more = make_training_lights(low, high, {.lights = 60, .seed = 4});
  std::set<float> training;
  for (size_t i = 0; i < lights.size(); ++i) {
    EXPECT_EQ(lights[i].position, more[i].position) << "more lights keep the first ones";
    training.insert(lights[i].position.x);
  }
  for (uint64_t i = 0; i < 50; ++i) {
    EXPECT_EQ(training.count(interpolate_light(low, high, 4, i).position.x), 0u);
  }
}

TEST(TrainingLights, ReportFaithfulIs200WithShadows) {
  EXPECT_EQ(report_faithful_training().lights, 200);
  EXPECT_TRUE(report_faithful_training().shadows);
  EXPECT_FALSE(TrainingParams{}.shadows);
}

Bounds unit_bounds() {
  Bounds bounds;
  bounds.extend(vec3(-1));
  bounds.extend(vec3(1));
  return bounds;
}

TEST(MixedTrainingLights, AreThreeQuartersInTheBoxAndTheRestFromAllSides) {
  const Light low = make_low();
  const Light high = make_high();
  // Three quarters, rounded up.
  for (const auto& [count, in_box] : {std::pair{1, 1}, {2, 2}, {3, 3}, {7, 6}, {64, 48}}) {
    const std::vector<Light> lights =
        make_mixed_training_lights(low, high, unit_bounds(), count, 0);
    ASSERT_EQ(static_cast<int>(lights.size()), count);
    for (int i = 0; i < count; ++i) {
      if (i < in_box) {
        EXPECT_EQ(lights[i].type, LightType::point);
        EXPECT_TRUE(within(low.position, lights[i].position, high.position));
      } else {
        EXPECT_EQ(lights[i].type, LightType::directional);
        EXPECT_NEAR(glm::length(lights[i].direction), 1, 1e-5);
      }
      EXPECT_TRUE(within(low.color, lights[i].color, high.color));
      EXPECT_NO_THROW(validate_light(lights[i], "light"));
    }
  }
}

/// The mean squared difference of `counts` from their mean.
double variance_of(const std::array<int, 8>& counts) {
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / 8;
  double squares = 0;
  for (const int n : counts) squares += (n - mean) * (n - mean);
  return squares / 8;
}

TEST(MixedTrainingLights, AreSpreadMoreEvenlyThanRandomOnes) {
  const Light low = make_low();
  const Light high = make_high();
  double in_box = 0;
  double around = 0;
  constexpr int seeds = 20;
  for (uint64_t seed = 0; seed < seeds; ++seed) {
    std::array<int, 8> octants{};
    std::array<int, 8> sides{};
    for (const Light& light : make_mixed_training_lights(low, high, unit_bounds(), 128, seed)) {
      const vec3 p = light.type == LightType::directional ? light.direction
                                                          : light.position - vec3(1, 3, 1.5f);
      const int octant = (p.x > 0 ? 1 : 0) + (p.y > 0 ? 2 : 0) + (p.z > 0 ? 4 : 0);
      ++(light.type == LightType::directional ? sides : octants)[octant];
    }
    in_box += variance_of(octants) / seeds;
    around += variance_of(sides) / seeds;
  }
  // Of n random lights n / 8 fall into each octant with variance n 7 / 64.
  EXPECT_LT(in_box, 0.5 * 96 * 7 / 64);
  EXPECT_LT(around, 0.5 * 32 * 7 / 64);
}

TEST(MixedTrainingLights, DirectionalOnesAreAsBrightAtTheCentre) {
  Light low = make_low();
  Light high = make_high();
  low.gain = high.gain = 20;
  const std::vector<Light> lights = make_mixed_training_lights(low, high, unit_bounds(), 64, 3);
  double box = 0;
  for (int i = 0; i < 48; ++i) {
    const vec3 p = lights[i].position;
    box += 20 / std::max(3.0, double{glm::dot(p, p)}) / 48;
  }
  for (int i = 48; i < 64; ++i) EXPECT_NEAR(lights[i].gain, box, 1e-4 * box);
}

TEST(MixedTrainingLights, SurviveExtremes) {
  for (const float scale : {1e-20f, 1e-6f, 1e6f, 1e14f}) {
    Light low = make_low();
    Light high = make_high();
    low.position *= scale;
    high.position *= scale;
    low.gain = high.gain = 1e20f;
    low.direction = high.direction = vec3(scale, 0, 0);
    Bounds bounds;
    bounds.extend(vec3(-scale));
    bounds.extend(vec3(scale));
    for (const Light& light : make_mixed_training_lights(low, high, bounds, 9, 0)) {
      EXPECT_NO_THROW(validate_light(light, "light")) << scale;
    }
    EXPECT_NO_THROW(make_mixed_training_lights(low, low, Bounds{}, 9, 0));
  }
}

/// Samples of all types in one pixel.
struct Pixel {
  std::vector<SampleType> types = test::all_sample_types();
  std::vector<std::vector<float>> values;
  std::vector<SampleMatrix> matrices;

  explicit Pixel(int rows) {
    Random random(6, RandomStream::tests, 0);
    for (const SampleType& type : types) {
      std::vector<float>& rows_of_type = values.emplace_back();
      for (int i = 0; i < rows; ++i) {
        test::append_random_vector(type, random, rows_of_type);
        test::widen_highlight(type, &rows_of_type[rows_of_type.size() - type.width]);
      }
    }
    for (size_t t = 0; t < types.size(); ++t)
      matrices.push_back({&types[t], values[t].data(), rows});
  }
};

std::vector<Light> some_lights() {
  std::vector<Light> lights = make_training_lights(make_low(), make_high(), {.lights = 20});
  for (int i = 0; i < 3; ++i) {
    Light sun = lights[i];
    sun.type = LightType::directional;
    lights.push_back(sun);
  }
  return lights;
}

TEST(EvaluateTraining, GivesTheReferencesValuesAndTheirMean) {
  const Pixel pixel(5);
  const vec3 eye(0, 0, 6);
  const std::vector<Light> lights = some_lights();
  const TrainingSet training = make_training_set(lights, pixel.types, eye, 1);
  PixelResponses responses;
  evaluate_training(training, pixel.matrices, 1.0f / 25, responses);
  const int columns = training.lights->columns();
  ASSERT_EQ(responses.columns, columns);
  std::vector<double> target(static_cast<size_t>(3) * columns, 0.0);
  for (size_t t = 0; t < pixel.types.size(); ++t) {
    for (int row = 0; row < 5; ++row) {
      for (int j = 0; j < columns; ++j) {
        const Light& light = training.lights->lights[j];
        const dvec3 expected =
            reference_response(pixel.types[t], pixel.matrices[t].row(row), light, eye, 1);
        for (int c = 0; c < 3; ++c) {
          const double value = expected[static_cast<size_t>(c)] * training.lights->weights[c][j];
          ASSERT_NEAR(responses.v[t][(row * 3 + c) * columns + j], value, 2e-4 * (1 + value));
          target[c * columns + j] += value / 25;
        }
      }
    }
  }
  for (int i = 0; i < 3 * columns; ++i)
    ASSERT_NEAR(responses.target[i], target[i], 1e-3 * (1 + target[i]));
}

/// Sees exactly the receivers whose x is below a limit, and checks what it is asked.
class HalfSpace final : public VisibilitySource {
 public:
  HalfSpace(const Pixel& pixel, float limit) : pixel_(pixel), limit_(limit) {}
  void prepare(const Light&) override {}
  void visibility(const Receivers& receivers, float* visibility) const override {
    for (int i = 0; i < receivers.count; ++i) {
      EXPECT_GT(receivers.weight[i], 0);
      EXPECT_EQ(receivers.bias[i], 1e-4f);
      EXPECT_TRUE(is_sample(receivers, i));
      visibility[i] = receivers.position[0][i] < limit_ ? 1.0f : 0.25f;
    }
  }

 private:
  bool is_sample(const Receivers& receivers, int i) const {
    for (const SampleMatrix& matrix : pixel_.matrices) {
      const bool leaf = matrix.type->shader == &Leaf::info;
      const bool strand = matrix.type->shader == &KajiyaKay::info;
      const float* v = matrix.row(i);
      bool same = receivers.lit_from_behind == leaf && (receivers.normal[0] == nullptr) == strand;
      for (int c = 0; c < 3; ++c) {
        same = same && receivers.position[c][i] == v[c];
        same = same && (strand || receivers.normal[c][i] == v[4 + c]);
      }
      if (same) return true;
    }
    return false;
  }

  const Pixel& pixel_;
  float limit_;
};

TEST(EvaluateTraining, MultipliesByVisibilityAndLeavesLobesAlone) {
  const Pixel pixel(6);
  const std::vector<Light> lights = some_lights();
  TrainingSet training = make_training_set(lights, pixel.types, {0, 0, 6}, 1);
  const int columns = training.lights->columns();
  PixelResponses open;
  evaluate_training(training, pixel.matrices, 0.04f, open);
  const HalfSpace shadow(pixel, 0.1f);
  // Every third column has no source: that light casts no shadow.
  for (int j = 0; j < columns; ++j) training.visibility.push_back(j % 3 == 0 ? nullptr : &shadow);
  PixelResponses shadowed;
  evaluate_training(training, pixel.matrices, 0.04f, shadowed);
  EXPECT_EQ(open.lobes, shadowed.lobes);
  std::vector<double> target(static_cast<size_t>(3) * columns, 0.0);
  for (size_t t = 0; t < pixel.types.size(); ++t) {
    for (int row = 0; row < 6; ++row) {
      for (int i = 0; i < 3 * columns; ++i) {
        const bool lit = i % columns % 3 == 0 || pixel.matrices[t].row(row)[0] < 0.1f;
        const size_t at = static_cast<size_t>(row) * 3 * columns + i;
        ASSERT_EQ(shadowed.v[t][at], open.v[t][at] * (lit ? 1.0f : 0.25f));
        target[i] += 0.04 * shadowed.v[t][at];
      }
    }
  }
  for (int i = 0; i < 3 * columns; ++i) {
    ASSERT_NEAR(shadowed.target[i], target[i], 1e-5 * (1 + target[i]));
  }
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "core/math/vec.h"
#include "reduction/representatives.h"

namespace relume {
namespace {

/// A matrix of values and the pixel it belongs to, by hand or at random.
struct Pixel {
  std::vector<float> values;
  std::vector<float> target;
  int rows = 0;

  ValueRows v() const { return {values.data(), rows, static_cast<int>(target.size())}; }
};

/// `rows` samples under `length` / 3 lights, of which the pixel holds `others` more.
Pixel random_pixel(int rows, int length, int others, uint64_t seed) {
  Random random(seed, RandomStream::tests, 0);
  Pixel pixel;
  pixel.rows = rows;
  pixel.target.assign(length, 0.0f);
  for (int row = 0; row < rows + others; ++row) {
    const float brightness = random.uniform();
    for (int i = 0; i < length; ++i) {
      const float value = brightness * random.uniform();
      pixel.target[i] += value / static_cast<float>(rows + others);
      if (row < rows) pixel.values.push_back(value);
    }
  }
  return pixel;
}

/// Eq. 4 and 6 as written, in double: the squared distance of the mean of `rows` from the pixel.
double error_of_mean(const Pixel& pixel, const std::vector<int>& rows) {
  const ValueRows v = pixel.v();
  double sum = 0;
  for (int i = 0; i < v.length; ++i) {
    double mean = 0;
    for (const int row : rows) mean += v.row(row)[i];
    mean /= static_cast<double>(rows.size());
    sum += (mean - pixel.target[i]) * (mean - pixel.target[i]);
  }
  return sum;
}

TEST(Equation4, IsTheSquaredDistanceFromThePixel) {
  const Pixel pixel = random_pixel(9, 48, 3, 1);
  std::vector<float> errors;
  eval_errors(pixel.v(), pixel.target.data(), errors);
  ASSERT_EQ(errors.size(), 9u);
  for (int row = 0; row < 9; ++row) {
    EXPECT_NEAR(errors[row], error_of_mean(pixel, {row}), 1e-5);
  }
}

TEST(Equation4, AcceptsAnyNumberOfValuesARow) {
  for (const int length : {1, 3, 15, 16, 17, 31, 33, 600}) {
    const Pixel pixel = random_pixel(3, length, 0, static_cast<uint64_t>(length));
    std::vector<float> errors;
    eval_errors(pixel.v(), pixel.target.data(), errors);
    for (int row = 0; row < 3; ++row) {
      EXPECT_NEAR(errors[row], error_of_mean(pixel, {row}), 1e-5 * (1 + errors[row])) << length;
    }
  }
}

TEST(LightMetric1Representatives, AreTheClosestRowsBestFirst) {
  EXPECT_EQ(closest_rows(std::vector<float>{3, 1, 2, 1, 0.5f}, 3), (std::vector<int>{4, 1, 3}));
  EXPECT_EQ(closest_rows(std::vector<float>{2, 2, 2}, 2), (std::vector<int>{0, 1})) << "ties";
  for (uint64_t seed = 0; seed < 50; ++seed) {
    const Pixel pixel = random_pixel(25, 30, 4, seed);
    std::vector<float> errors;
    eval_errors(pixel.v(), pixel.target.data(), errors);
    const std::vector<int> chosen = closest_rows(errors, 8);
    const std::set<int> set(chosen.begin(), chosen.end());
    ASSERT_EQ(set.size(), 8u);
    for (int row = 0; row < 25; ++row) {
      if (set.count(row) > 0) continue;
      ASSERT_GE(errors[row], errors[chosen.back()]);
    }
  }
}

TEST(LightMetric4Representatives, EveryGreedyStepIsTheBruteForceMinimum) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    const Pixel pixel = random_pixel(25, 48, static_cast<int>(seed % 7), seed);
    const std::vector<int> chosen = greedy_rows(pixel.v(), pixel.target.data(), 25);
    ASSERT_EQ(std::set<int>(chosen.begin(), chosen.end()).size(), 25u);
    std::vector<int> taken;
    for (const int row : chosen) {
      double least = std::numeric_limits<double>::infinity();
      for (int candidate = 0; candidate < 25; ++candidate) {
        if (std::count(taken.begin(), taken.end(), candidate) > 0) continue;
        std::vector<int> with = taken;
        with.push_back(candidate);
        least = std::min(least, error_of_mean(pixel, with));
      }
      taken.push_back(row);
      ASSERT_NEAR(error_of_mean(pixel, taken), least, 1e-6 * (1 + least))
          << "seed " << seed << " step " << taken.size();
    }
  }
}

TEST(LightMetric4Representatives, StartWithTheClosestAndBreakTiesDownwards) {
  const Pixel pixel = random_pixel(12, 33, 2, 5);
  std::vector<float> errors;
  eval_errors(pixel.v(), pixel.target.data(), errors);
  EXPECT_EQ(greedy_rows(pixel.v(), pixel.target.data(), 1), closest_rows(errors, 1));
  const Pixel equal{std::vector<float>(5 * 3, 0.25f), {0.5f, 0.5f, 0.5f}, 5};
  EXPECT_EQ(greedy_rows(equal.v(), equal.target.data(), 4), (std::vector<int>{0, 1, 2, 3}));
}

TEST(LightMetric4Representatives, BalanceWhatLightMetric1DoesNot) {
  // One value a sample: three at 0.4, one at 1, and the pixel at 0.6. After 0.4 the mean with 1 is
  // closer than 0.4 again, then the mean of 0.4, 1 and 0.4 is exact.
  const Pixel pixel{{0.4f, 0.4f, 0.4f, 1.0f}, {0.6f}, 4};
  std::vector<float> errors;
  eval_errors(pixel.v(), pixel.target.data(), errors);
  EXPECT_EQ(closest_rows(errors, 3), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(greedy_rows(pixel.v(), pixel.target.data(), 3), (std::vector<int>{0, 3, 1}));
}

TEST(ShaderGroups, SplitByAngleAndByDistance) {
  // Blue, blue, red, a darker blue within sqrt(3) / 5 of the mean, a far brighter blue.
  const std::vector<vec3> colors{{0, 0, 0.5f}, {0, 0, 0.6f}, {0.5f, 0, 0}, {0, 0, 0.3f}, {0, 0, 1}};
  EXPECT_EQ(make_shader_groups(colors), (std::vector<int>{0, 0, 1, 0, 2}));
}

TEST(ShaderGroups, ThresholdsAreThirtyDegreesAndRootThreeFifths) {
  const auto turned = [](double degrees) {
    const double angle = degrees * 3.14159265358979323846 / 180;
    return vec3(0.1 * std::cos(angle), 0.1 * std::sin(angle), 0);
  };
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{turned(0), turned(29.9)}),
            (std::vector<int>{0, 0}));
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{turned(0), turned(30.1)}),
            (std::vector<int>{0, 1}));
  const float limit = std::sqrt(3.0f) / 5;
  const vec3 start(0.5f, 0, 0);
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{start, {0.5f + 0.999f * limit, 0, 0}}),
            (std::vector<int>{0, 0}));
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{start, {0.5f + 1.001f * limit, 0, 0}}),
            (std::vector<int>{0, 1}));
}

TEST(ShaderGroups, CompareWithTheRunningMean) {
  // 0.8 is too far from 0.4, but not from the mean of 0.4 and 0.7.
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{{0.4f, 0, 0}, {0.8f, 0, 0}}),
            (std::vector<int>{0, 1}));
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{{0.4f, 0, 0}, {0.7f, 0, 0}, {0.8f, 0, 0}}),
            (std::vector<int>{0, 0, 0}));
}

TEST(ShaderGroups, JoinTheFirstThatFits) {
  // Groups at 0.2 and 0.6; 0.4 fits both.
  EXPECT_EQ(make_shader_groups(std::vector<vec3>{{0.2f, 0, 0}, {0.6f, 0, 0}, {0.4f, 0, 0}}),
            (std::vector<int>{0, 1, 0}));
}

TEST(ShaderGroups, BlackIsADirectionOfItsOwn) {
  const std::vector<vec3> colors{{0, 0, 0}, {0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(make_shader_groups(colors), (std::vector<int>{0, 0, 1, 0}));
}

TEST(ShaderGroups, SurviveExtremeColors) {
  const std::vector<vec3> colors{vec3(1e30f), vec3(1e30f), vec3(1e-30f), vec3(1e-38f), vec3(0)};
  const std::vector<int> groups = make_shader_groups(colors);
  EXPECT_EQ(groups, (std::vector<int>{0, 0, 1, 1, 2}));
}

/// The report's example, sec. 3.3: six blue samples and two red ones.
const std::vector<int> six_and_two{0, 0, 0, 1, 0, 0, 1, 0};

TEST(LightMetric2Representatives, GiveSixBlueAndTwoRedThreeToOne) {
  // All blue samples are closer to the pixel: Light Metric 1 takes four of them.
  const std::vector<float> errors{0.1f, 0.2f, 0.15f, 0.9f, 0.3f, 0.25f, 0.8f, 0.35f};
  for (const int row : closest_rows(errors, 4)) EXPECT_EQ(six_and_two[row], 0);
  std::map<int, int> histogram;
  constexpr int trials = 4000;
  for (uint64_t trial = 0; trial < trials; ++trial) {
    Random random(11, RandomStream::reduction, trial);
    int red = 0;
    for (const int row : draw_from_groups(six_and_two, errors, 4, random)) red += six_and_two[row];
    ++histogram[red];
  }
  // Four draws at 3/4 and 1/4, at most two red ones: expected 4/4 (81 * 0 + 108 * 1 + 67 * 2) /
  // 256.
  const double mean = (histogram[1] + 2.0 * histogram[2]) / trials;
  EXPECT_NEAR(mean, 242.0 / 256, 0.04);
  EXPECT_NEAR(histogram[0] / double{trials}, 81.0 / 256, 0.03);
  EXPECT_NEAR(histogram[1] / double{trials}, 108.0 / 256, 0.03);
  EXPECT_EQ(histogram.rbegin()->first, 2);
}

TEST(LightMetric2Representatives, TakeTheLeastErrorOfTheDrawnGroup) {
  const std::vector<float> errors{0.4f, 0.2f, 0.15f, 0.9f, 0.3f, 0.25f, 0.8f, 0.2f};
  for (uint64_t trial = 0; trial < 100; ++trial) {
    Random random(3, RandomStream::tests, trial);
    std::vector<int> taken;
    for (const int row : draw_from_groups(six_and_two, errors, 8, random)) {
      for (int other = 0; other < 8; ++other) {
        const bool free = std::count(taken.begin(), taken.end(), other) == 0;
        if (!free || six_and_two[other] != six_and_two[row] || other == row) continue;
        ASSERT_TRUE(errors[row] < errors[other] || (errors[row] == errors[other] && row < other));
      }
      taken.push_back(row);
    }
    ASSERT_EQ(std::set<int>(taken.begin(), taken.end()).size(), 8u) << "emptied groups are skipped";
  }
}

TEST(LightMetric2Representatives, FollowTheGenerator) {
  const std::vector<float> errors(8, 1.0f);
  Random first(5, RandomStream::reduction, 77);
  Random second(5, RandomStream::reduction, 77);
  EXPECT_EQ(draw_from_groups(six_and_two, errors, 5, first),
            draw_from_groups(six_and_two, errors, 5, second));
}

Features make_features(std::vector<float> values, int dimensions) {
  Features features;
  features.dimensions = dimensions;
  features.rows = static_cast<int>(values.size()) / dimensions;
  features.values = std::move(values);
  return features;
}

TEST(AssignToRepresentatives, TakesTheNearestWithoutMovingCentroids) {
  // k-means would move the centroid of {0, 4} and lose 4 to 6.
  const Features features = make_features({0, 4, 6, 9}, 1);
  const Clustering clustering = assign_to_representatives(features, std::vector<int>{3, 0});
  EXPECT_EQ(clustering.cluster_of, (std::vector<int>{1, 1, 0, 0}));
  EXPECT_EQ(clustering.representatives, (std::vector<int>{3, 0}));
}

TEST(AssignToRepresentatives, TiesGoToTheFirstChosenAndDoublesAreDropped) {
  const Features features = make_features({0, 2, 1, 0, 5}, 1);
  const Clustering clustering = assign_to_representatives(features, std::vector<int>{1, 0, 3, 4});
  EXPECT_EQ(clustering.representatives, (std::vector<int>{1, 0, 4}));
  EXPECT_EQ(clustering.cluster_of, (std::vector<int>{1, 0, 0, 1, 2}));
}

TEST(ChooseRepresentatives, TakesTheLeastErrorOfEachCluster) {
  Clustering clustering{{0, 1, 0, 1, 0}, {0, 1}};
  choose_representatives(std::vector<float>{3, 5, 2, 5, 2}, clustering);
  EXPECT_EQ(clustering.representatives, (std::vector<int>{2, 1}));
}

}  // namespace
}  // namespace relume

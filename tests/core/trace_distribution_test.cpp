// What is random, as distributions: positions in pixels, what they hit, frames of few samples. Each
// test also shows the bias that it finds.

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/samples/sample_scene.h"
#include "core/scene/light.h"
#include "core/trace/pixel_sampler.h"
#include "tests/support/pixel_statistics.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

constexpr double level = 0.01;

TEST(PixelStatistics, StudentsTIsThatOfTables) {
  EXPECT_NEAR(student_p(12.706, 1), 0.05, 1e-5);
  EXPECT_NEAR(student_p(-2.228, 10), 0.05, 1e-4);
  EXPECT_NEAR(student_p(2.807, 23), 0.01, 1e-4);
  EXPECT_NEAR(student_p(1.96, 1e6), 0.05, 1e-4);
  EXPECT_EQ(student_p(0, 5), 1);
}

TEST(PixelStatistics, RightMethodsFailOnceInAHundredTests) {
  // 400 tests of 50 pixels of a right method: 4 are expected below 0.01.
  int below = 0;
  for (int test = 0; test < 400; ++test) {
    PixelMoments moments;
    Random random(1, RandomStream::tests, test);
    for (int trial = 0; trial < 30; ++trial) {
      std::array<double, 50> values;
      for (double& value : values) value = random.uniform() + random.uniform();
      moments.add(values);
    }
    below += p_of_mean(moments, std::vector<double>(50, 1.0)) < level ? 1 : 0;
  }
  EXPECT_LE(below, 12);
}

/// Where samples lie within their cells, [0, 1)^2, as counts of 16 x 16 bins. `power` other than 1
/// bends the first coordinate.
std::vector<size_t> count_in_cells(int spp, double power) {
  const PixelStrata strata = make_pixel_strata(spp);
  std::vector<size_t> counts(256);
  std::vector<vec2> positions;
  for (uint64_t pixel = 0; pixel < 400'000u / static_cast<unsigned>(spp); ++pixel) {
    positions.clear();
    sample_pixel(strata, 5, pixel, positions);
    size_t i = 0;
    double top = 0;
    for (const int columns : strata.columns) {
      const double height = static_cast<double>(columns) / spp;
      for (int column = 0; column < columns; ++column, ++i) {
        const double u = std::clamp(static_cast<double>(positions[i].x) * columns - column, 0., 1.);
        const double v = std::clamp((static_cast<double>(positions[i].y) - top) / height, 0., 1.);
        const auto bin = [](double x) { return std::min<size_t>(15, static_cast<size_t>(16 * x)); };
        ++counts[bin(v) * 16 + bin(std::pow(u, power))];
      }
      top += height;
    }
  }
  return counts;
}

TEST(PixelSampler, CellsAreFilledEvenly) {
  for (const int spp : {1, 2, 7, 25}) {
    EXPECT_GT(p_of_even_counts(count_in_cells(spp, 1)), level / 4) << spp;
    EXPECT_LT(p_of_even_counts(count_in_cells(spp, 1.02)), level / 4)
        << spp << ": a bend of 2 % is found";
  }
}

constexpr int side = 16;

/// The weights of every pixel's samples.
std::vector<double> coverage_of(const Scene& scene, const Tracer& tracer, int spp, uint64_t seed) {
  const ViewSampler view = make_view_sampler(scene, tracer, side, side, spp, seed);
  const SampleTile tile = sample_tile(view, 0);
  std::vector<double> coverage(side * side);
  for (const TypedRows& rows : tile.types) {
    for (size_t p = 0; p < coverage.size(); ++p) {
      for (uint32_t r = rows.first[p]; r < rows.first[p + 1]; ++r) coverage[p] += rows.weights[r];
    }
  }
  return coverage;
}

/// A long strand upright in front of a camera far away: a rectangle on the image plane.
struct StrandView {
  double x = 0;       ///< world, of its axis
  double radius = 0;  ///< world
  static constexpr double distance = 100;
  static constexpr double fov_deg = 1;

  Scene scene() const {
    Scene scene = make_empty_scene(make_camera({0, 0, distance}, {0, 0, 0}, fov_deg), side, side);
    const auto x_float = static_cast<float>(x);
    add_shape(scene, make_strand({x_float, -5, 0}, {x_float, 5, 0}, static_cast<float>(radius), 1,
                                 add_material(scene, "kajiya-kay")));
    return scene;
  }
  /// The part of each pixel that it covers.
  std::vector<double> coverage() const {
    const double pixel = 2 * distance * std::tan(fov_deg * 3.14159265358979323846 / 360) / side;
    std::vector<double> result(side * side);
    for (int column = 0; column < side; ++column) {
      const double left = (column - side / 2) * pixel;
      const double overlap = std::min(left + pixel, x + radius) - std::max(left, x - radius);
      for (int row = 0; row < side; ++row) {
        result[static_cast<size_t>(row) * side + column] = std::max(0.0, overlap) / pixel;
      }
    }
    return result;
  }
};

TEST(CurveHits, CoverWhatTheStrandCovers) {
  for (const StrandView& strand : {StrandView{0.031, 0.011}, {0.109, 0.02}, {-0.2, 0.15}}) {
    const Scene scene = strand.scene();
    const Tracer tracer(scene);
    for (const int spp : {1, 4, 7}) {
      PixelMoments moments;
      for (uint64_t seed = 1; seed <= 1600u / static_cast<unsigned>(spp); ++seed) {
        moments.add(coverage_of(scene, tracer, spp, seed));
      }
      EXPECT_GT(p_of_mean(moments, strand.coverage()), level / 9) << strand.x << ", " << spp;
      StrandView wider = strand;
      wider.radius *= 1.08;
      EXPECT_LT(p_of_mean(moments, wider.coverage()), level / 9)
          << strand.x << ", " << spp << ": a strand that is 8 % wider is told apart";
    }
  }
}

/// Red of the frame of all samples, as means of 4 x 4 pixels: single ones that a few trials hit are
/// far from normal.
std::vector<double> frame_of(const Scene& scene, const Tracer& tracer, int spp, uint64_t seed,
                             double factor) {
  const RelightCache cache = make_full_cache(scene, tracer, spp, seed);
  const Image frame = render_frame(cache, scene.lights);
  std::vector<double> red(side * side / 16);
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      red[static_cast<size_t>(y / 4) * (side / 4) + x / 4] +=
          factor / 16 * frame.rgb(static_cast<size_t>(y) * side + x).x;
    }
  }
  return red;
}

PixelMoments frame_moments(const Scene& scene, const Tracer& tracer, int spp, int trials,
                           double factor = 1) {
  PixelMoments moments;
  for (int trial = 0; trial < trials; ++trial) {
    moments.add(frame_of(scene, tracer, spp, static_cast<uint64_t>(1000 * spp + trial), factor));
  }
  return moments;
}

/// Few fresh samples, the report's PURE, are right on average: as many are.
TEST(FramesOfFewSamples, AreUnbiased) {
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0.4f, 0}, 40), side, side);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  const uint32_t gloss = add_material(scene, "phong");
  add_shape(scene, make_sphere({0, 0.3f, -1}, 0.7f, 12, gloss));
  for (int i = 0; i < 20; ++i) {
    const float x = -1.2f + 0.12f * static_cast<float>(i);
    add_shape(scene, make_strand({x, -0.5f, 0}, {x + 0.1f, 0.9f, 0.1f}, 0.012f, 3, hair));
  }
  scene.lights = {make_point_light({2, 3, 2}, 20), make_directional_light({1, -1, -1}, 0.5f)};
  const Tracer tracer(scene);
  const PixelMoments many = frame_moments(scene, tracer, 64, 30);
  for (const int spp : {1, 3}) {
    const int trials = 600 / spp;
    EXPECT_GT(p_of_difference(frame_moments(scene, tracer, spp, trials), many), level / 2) << spp;
    EXPECT_LT(p_of_difference(frame_moments(scene, tracer, spp, trials, 1.03), many), level / 2)
        << spp << ": 3 % too bright is found";
  }
}

/// Random lights lie evenly between the two that bound them, each parameter by itself.
TEST(InterpolatedLights, AreEvenAndIndependent) {
  const Light low = make_point_light({-2, 1, 3}, 2);
  const Light high = make_point_light({4, 2, 5}, 10);
  std::vector<size_t> across(256);
  std::vector<size_t> with_gain(256);
  std::vector<size_t> bent(256);
  const auto bin = [](double x) { return std::min<size_t>(15, static_cast<size_t>(16 * x)); };
  for (uint64_t i = 0; i < 100'000; ++i) {
    const Light light = interpolate_light(low, high, 3, i);
    const double x = (static_cast<double>(light.position.x) + 2) / 6;
    const double y = static_cast<double>(light.position.y) - 1;
    const double gain = (static_cast<double>(light.gain) - 2) / 8;
    ++across[bin(y) * 16 + bin(x)];
    ++with_gain[bin(gain) * 16 + bin(x)];
    ++bent[bin(y) * 16 + bin(std::pow(x, 1.04))];
  }
  EXPECT_GT(p_of_even_counts(across), level / 2);
  EXPECT_GT(p_of_even_counts(with_gain), level / 2);
  EXPECT_LT(p_of_even_counts(bent), level / 2) << "a bend of 4 % is found";
}

}  // namespace
}  // namespace relume

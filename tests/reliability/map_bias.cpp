// Where `coverage` is wrong on average: its bias, pixel by pixel.
// Usage: map_bias SCENE SIDE SEEDS PICTURE [JSON]
// SCENE is prepared SEEDS times at SIDE x SIDE pixels, each time with other samples, 4 records a
// pixel. Each time every pixel's visibility of the scene's first light is found twice from the same
// records: by coverage, and by a ray from each of their members, which is right on average
// (VisibilityStatistics.RaysFromAllMembersAreUnbiased). The mean of the differences is the bias,
// its standard error comes from their variance. PICTURE shows the bias of squares of 4 x 4 pixels:
// red where too light, blue where too dark, full colour at 0.1. Exits with 1 where the mean over
// the picture is beyond 0.02. By ./dev bias.

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/image/image_io.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "shadow/coverage.h"
#include "shadow/members.h"
#include "tests/support/merged_cache.h"
#include "tests/support/pixel_statistics.h"
#include "viewer/commands/version.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

constexpr double largest_mean_bias = 0.02;
constexpr double full_color = 0.1;
constexpr int square = 4;

/// What a bias map is summed up to; visibilities are in [0, 1], of pixels that see anything.
struct BiasFigures {
  double mean = 0;         ///< over the picture, signed
  double rms = 0;          ///< of the squares, without what noise adds to it
  double significant = 0;  ///< share of squares whose bias is above 3 standard errors
  double largest = 0;      ///< of the squares, in size
  double p = 0;            ///< that there is none, over all squares
};

/// Means over squares of `side` x `side` pixels; squares that see nothing stay 0.
std::vector<double> square_means(const std::vector<double>& pixels, int side) {
  const int squares = side / square;
  std::vector<double> means(static_cast<size_t>(squares) * squares);
  for (int y = 0; y < squares * square; ++y) {
    for (int x = 0; x < squares * square; ++x) {
      means[static_cast<size_t>(y / square) * squares + x / square] +=
          pixels[static_cast<size_t>(y) * side + x] / (square * square);
    }
  }
  return means;
}

BiasFigures sum_up(const test::PixelMoments& bias) {
  BiasFigures figures;
  double squares = 0;
  for (size_t i = 0; i < bias.pixels(); ++i) {
    const double variance = bias.variance_of_mean(i);
    if (variance == 0 && bias.mean(i) == 0) continue;
    ++squares;
    figures.mean += bias.mean(i);
    figures.rms += bias.mean(i) * bias.mean(i) - variance;
    figures.largest = std::max(figures.largest, std::abs(bias.mean(i)));
    if (std::abs(bias.mean(i)) > 3 * std::sqrt(variance)) ++figures.significant;
  }
  squares = std::max(squares, 1.0);
  figures.mean /= squares;
  figures.rms = std::sqrt(std::max(figures.rms / squares, 0.0));
  figures.significant /= squares;
  const std::vector<double> none(bias.pixels(), 0.0);
  figures.p = test::p_of_mean(bias, none);
  return figures;
}

uint8_t to_byte(double value) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

/// White where there is none, each square `square` x `square` pixels.
DisplayImage draw_bias(const test::PixelMoments& bias, int side) {
  const int squares = side / square;
  DisplayImage image{squares * square, squares * square, 3, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const size_t at = static_cast<size_t>(y / square) * squares + x / square;
      const double strength = bias.mean(at) / full_color;
      image.pixels.push_back(to_byte(1 + std::min(strength, 0.0)));
      image.pixels.push_back(to_byte(1 - std::abs(strength)));
      image.pixels.push_back(to_byte(1 - std::max(strength, 0.0)));
    }
  }
  return image;
}

test::PixelMoments measure(const Scene& scene, const Tracer& tracer, int side, int seeds) {
  PrepareParams params;
  params.width = side;
  params.height = side;
  params.reduction.records = 4;
  params.reduction.stored_members = max_members;
  test::PixelMoments moments;
  for (int seed = 1; seed <= seeds; ++seed) {
    params.reduction.seed = static_cast<uint64_t>(seed);
    const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
    CoverageVisibility coverage(tracer, cache);
    MemberVisibility members(tracer, cache, max_members);
    std::vector<double> difference = test::pixel_visibility(cache, coverage, scene.lights.front());
    const std::vector<double> truth = test::pixel_visibility(cache, members, scene.lights.front());
    for (size_t i = 0; i < truth.size(); ++i) difference[i] -= truth[i];
    moments.add(square_means(difference, side));
  }
  return moments;
}

int run(int argc, char** argv) {
  if (argc < 5) throw Error(ErrorKind::usage, "map_bias SCENE SIDE SEEDS PICTURE [JSON]");
  const Scene scene = load_scene(argv[1], shader_table());
  const int side = std::stoi(argv[2]);
  const int seeds = std::stoi(argv[3]);
  const Tracer tracer(scene);
  const test::PixelMoments bias = measure(scene, tracer, side, seeds);
  const BiasFigures figures = sum_up(bias);
  write_png(argv[4], draw_bias(bias, side));
  const nlohmann::json row = {{"schema", "relume-bias-1"},
                              {"commit", relume_commit},
                              {"scene", scene.name},
                              {"side", side},
                              {"seeds", seeds},
                              {"mean", figures.mean},
                              {"rms", figures.rms},
                              {"significant", figures.significant},
                              {"largest", figures.largest},
                              {"p", figures.p}};
  fmt::print("{}\n", row.dump(1));
  if (argc > 5) std::ofstream(argv[5]) << row.dump(1) << "\n";
  return std::abs(figures.mean) <= largest_mean_bias ? 0 : 1;
}

}  // namespace
}  // namespace relume

int main(int argc, char** argv) {
  try {
    return relume::run(argc, argv);
  } catch (const relume::Error& error) {
    fmt::print(stderr, "map_bias: {}\n", error.what());
    return error.exit_code();
  }
}

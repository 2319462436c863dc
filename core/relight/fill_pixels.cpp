#include "core/relight/fill_pixels.h"

#include "core/samples/sample_tile.h"

namespace relume {
namespace {

/// Red, green, blue and coverage of a tile's known pixels, 0 elsewhere and on a border around it.
struct Planes {
  static constexpr int size = tile_size + 2;
  float values[4][size][size] = {};
};

/// Place of a tile's pixel in a plane.
struct Place {
  int y;
  int x;
};

Place place_of(int pixel) {
  return {pixel / tile_size + 1, pixel % tile_size + 1};
}

float coverage_of(const PackedTile& tile, int pixel) {
  return static_cast<float>(tile.coverage[pixel / tile_size * tile.width + pixel % tile_size]);
}

Planes known_pixels(const RelightCache& cache, const PackedTile& tile, int shaded,
                    const float* sums) {
  Planes planes;
  for (int b = 0; b < shaded; ++b) {
    const PackedBlock block = cache.block(tile, b);
    for (int lane = 0; lane < block.lanes; ++lane) {
      const auto [y, x] = place_of(block.pixels[lane]);
      for (int c = 0; c < 3; ++c) {
        planes.values[c][y][x] = sums[b * block_floats + c * block_lanes + lane];
      }
      planes.values[3][y][x] = coverage_of(tile, block.pixels[lane]);
    }
  }
  return planes;
}

/// Each value plus the eight around it.
Planes sum_neighbours(const Planes& planes) {
  Planes sums;
  for (int c = 0; c < 4; ++c) {
    float rows[Planes::size][Planes::size];
    for (int y = 0; y < Planes::size; ++y) {
      const float* in = planes.values[c][y];
      for (int x = 1; x <= tile_size; ++x) rows[y][x] = in[x - 1] + in[x] + in[x + 1];
    }
    for (int y = 1; y <= tile_size; ++y) {
      for (int x = 1; x <= tile_size; ++x) {
        sums.values[c][y][x] = rows[y - 1][x] + rows[y][x] + rows[y + 1][x];
      }
    }
  }
  return sums;
}

/// Mean radiance of what covers the known pixels.
vec3 mean_radiance(const Planes& planes) {
  vec4 sum(0);
  for (int c = 0; c < 4; ++c) {
    for (const auto& row : planes.values[c]) {
      for (const float value : row) sum[c] += value;
    }
  }
  return sum[3] > 0 ? vec3(sum) / sum[3] : vec3(0);
}

}  // namespace

void fill_pixels(const RelightCache& cache, const PackedTile& tile, int shaded, float* sums) {
  const Planes planes = known_pixels(cache, tile, shaded, sums);
  const Planes around = sum_neighbours(planes);
  const vec3 mean = mean_radiance(planes);
  for (int b = shaded; b < tile.block_count; ++b) {
    const PackedBlock block = cache.block(tile, b);
    for (int lane = 0; lane < block.lanes; ++lane) {
      const auto [y, x] = place_of(block.pixels[lane]);
      const float known = around.values[3][y][x];
      const float coverage = coverage_of(tile, block.pixels[lane]);
      for (int c = 0; c < 3; ++c) {
        const float radiance = known > 0 ? around.values[c][y][x] / known : mean[c];
        sums[b * block_floats + c * block_lanes + lane] = coverage * radiance;
      }
    }
  }
}

}  // namespace relume

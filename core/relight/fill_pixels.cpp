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

/// A value for each pixel of a tile.
using Pixels = float[tile_size][tile_size];

/// In 255ths.
struct Coverage {
  Pixels values = {};

  explicit Coverage(const PackedTile& tile) {
    for (int y = 0; y < tile.height; ++y) {
      const uint8_t* row = tile.coverage + y * tile.width;
      for (int x = 0; x < tile.width; ++x) values[y][x] = static_cast<float>(row[x]);
    }
  }
  float of(int pixel) const { return (&values[0][0])[pixel]; }
};

Planes known_pixels(const RelightCache& cache, const PackedTile& tile, int shaded,
                    const Coverage& coverage, const float* sums) {
  Planes planes;
  for (int b = 0; b < shaded; ++b) {
    const PackedBlock block = cache.block(tile, b);
    for (int lane = 0; lane < block.lanes; ++lane) {
      const auto [y, x] = place_of(block.pixels[lane]);
      for (int c = 0; c < 3; ++c) {
        planes.values[c][y][x] = sums[b * block_floats + c * block_lanes + lane];
      }
      planes.values[3][y][x] = coverage.of(block.pixels[lane]);
    }
  }
  return planes;
}

/// Sums of each row's values with their neighbours in it.
using Rows = float[Planes::size][tile_size];

void sum_in_rows(const float (&values)[Planes::size][Planes::size], Rows& sums) {
  for (int y = 0; y < Planes::size; ++y) {
    for (int x = 0; x < tile_size; ++x) {
      sums[y][x] = values[y][x] + values[y][x + 1] + values[y][x + 2];
    }
  }
}

/// Sums over each pixel and the eight around it.
void sum_around(const float (&values)[Planes::size][Planes::size], Pixels& sums) {
  Rows rows;
  sum_in_rows(values, rows);
  for (int y = 0; y < tile_size; ++y) {
    for (int x = 0; x < tile_size; ++x) sums[y][x] = rows[y][x] + rows[y + 1][x] + rows[y + 2][x];
  }
}

float sum_of(const float (&values)[Planes::size][Planes::size]) {
  float sum = 0;
  for (const auto& row : values) {
    for (const float value : row) sum += value;
  }
  return sum;
}

/// What pixels of `coverage` get from the mean radiance of what covers the pixels around them, or
/// the tile where those are empty.
struct Filled {
  Pixels rgb[3];

  Filled(const Planes& planes, const Coverage& coverage) {
    Pixels known;
    sum_around(planes.values[3], known);
    const float whole = sum_of(planes.values[3]);
    for (int c = 0; c < 3; ++c) {
      sum_around(planes.values[c], rgb[c]);
      const float mean = whole > 0 ? sum_of(planes.values[c]) / whole : 0.0f;
      for (int y = 0; y < tile_size; ++y) {
        for (int x = 0; x < tile_size; ++x) {
          const float around = rgb[c][y][x] / std::max(known[y][x], 1.0f);  // 0, or 1 and more
          rgb[c][y][x] = coverage.values[y][x] * (known[y][x] > 0 ? around : mean);
        }
      }
    }
  }
};

}  // namespace

void fill_pixels(const RelightCache& cache, const PackedTile& tile, int shaded, float* sums) {
  const Coverage coverage(tile);
  const Filled filled(known_pixels(cache, tile, shaded, coverage, sums), coverage);
  for (int b = shaded; b < tile.block_count; ++b) {
    const PackedBlock block = cache.block(tile, b);
    float* const rgb = sums + b * block_floats;
    for (int c = 0; c < 3; ++c) {
      const float* const values = &filled.rgb[c][0][0];
      for (int lane = 0; lane < block_lanes; ++lane) {
        rgb[c * block_lanes + lane] = values[block.pixels[lane]];
      }
    }
  }
}

}  // namespace relume

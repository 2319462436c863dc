#pragma once

#include "core/base/random.h"
#include "core/samples/relight_cache.h"
#include "core/samples/sample_tile.h"

// Records without a scene: random or hand-made sample vectors in tiles and caches.

namespace relume::test {

/// A unit vector, uniform on the sphere.
vec3 random_direction(Random& random);

/// A sample vector of `type`: position in the unit ball, bias 1e-4, unit directions, colours in
/// [0, 1], exponents log-uniform in [0, 1e5], other scalars uniform, with an exact 0 and
/// their largest value now and then. Appended to
/// `values`.
void append_random_vector(const SampleType& type, Random& random, std::vector<float>& values);

/// Widens the highlight of a sample vector to everyday size, for tests of sums: beyond, kernels and
/// reference differ by more than rounding. Exponents are at most 40, roughness at least 0.4.
void widen_highlight(const SampleType& type, float* vector);

/// The same for all rows of a tile.
void widen_highlights(std::span<const SampleType> types, SampleTile& tile);

/// A tile of random vectors: every pixel has 0 to `max_rows` rows of each type, weights sum to 1 or
/// less. Deterministic in `seed`.
SampleTile make_random_tile(std::span<const SampleType> types, int width, int height, int max_rows,
                            uint64_t seed);

/// Gives every pixel of the tile, covered or not, the predicted error 0.001 (1 + x + 3 y), x and y
/// in pixels of the image.
void fill_predicted_error(SampleTile& tile);

/// One type for each shader of the program.
std::vector<SampleType> all_sample_types();

/// A cache that holds one tile of records, seen from `eye`, with scene bounds of radius 1.
RelightCache make_tile_cache(const SampleTile& tile, const std::vector<SampleType>& types,
                             vec3 eye);

/// The tiles of a `width` x `height` image of random vectors, in image order. Deterministic.
std::vector<SampleTile> make_random_tiles(std::span<const SampleType> types, int width, int height,
                                          int max_rows);

/// The info of such a cache.
CacheInfo make_tile_info(const SampleTile& tile, const std::vector<SampleType>& types, vec3 eye);

}  // namespace relume::test

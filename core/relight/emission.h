#pragma once

#include "core/image/image.h"
#include "core/samples/relight_cache.h"

namespace relume {

/// What the materials of each pixel emit by themselves, RGB; black where the cache has no emission.
/// It is part of every frame, whatever the lights do.
Image emission_image(const RelightCache& cache);

/// Adds it to those pixels of a tile of `frame` that have records, whose sums were just written.
/// The others keep what emission_image() gave them. Finite pixels stay finite. `tile.emission` is
/// not null.
void add_emission(const RelightCache& cache, const PackedTile& tile, Image& frame);

}  // namespace relume

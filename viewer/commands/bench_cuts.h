#pragma once

#include "core/samples/relight_cache.h"

namespace relume {

/// What is left of a cache.
struct CutParams {
  int records = 0;    ///< of each covered pixel, repeated where it has fewer; 0 = as they are
  int tile_rows = 0;  ///< full rows of tiles, spread over the picture; 0 = all there are
};

/// Another cache of the same format from the records of `cache`, to time frames on: as many records
/// a pixel or as many pixels as asked for. Not meant to be looked at: repeated records make pixels
/// brighter.
RelightCache cut_cache(const RelightCache& cache, const CutParams& params);

enum class DiffuseShader { lambert, phong };

/// The cache's positions, directions and diffuse colours as records of another shader: Lambert, or
/// Phong without specular.
RelightCache make_diffuse_cache(const RelightCache& cache, DiffuseShader shader, int tile_rows);

/// Full rows of tiles whose pixels, of `records_per_pixel` each, hold at most `records` together;
/// at least one.
int tile_rows_for(const CacheInfo& info, double records, double records_per_pixel);

}  // namespace relume

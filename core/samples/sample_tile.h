#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/samples/footprint.h"
#include "core/samples/sample_type.h"

namespace relume {

inline constexpr int tile_size = 16;  ///< pixels; tiles at the right and bottom edge are smaller

/// All vectors of one type in a tile, pixel by pixel. Row r is values[r * width, (r + 1) * width).
struct TypedRows {
  std::vector<float> values;    ///< rows x width
  std::vector<float> weights;   ///< rows; > 0
  std::vector<uint32_t> first;  ///< pixels + 1: pixel p owns rows [first[p], first[p + 1])
  /// Reduced records only: rows, or empty where rows are samples.
  std::vector<Footprint> footprints;
  /// Members of row 0, then of row 1, ...: each row has footprints[row].stored_members. Rows of one
  /// sample need none.
  std::vector<Member> members;

  size_t rows() const { return weights.size(); }
};

/// A tile of the deep framebuffer: the typed sample vectors of up to 16 x 16 pixels, in sampling
/// order within a pixel and type. The same shape holds the tile's reduced records: then a row is a
/// record. The weights of a pixel, over all types, sum to its coverage (samples that hit / spp),
/// unless it has no records at all.
struct SampleTile {
  int x0 = 0;  ///< pixels, top left
  int y0 = 0;
  int width = 0;
  int height = 0;
  std::vector<TypedRows> types;  ///< parallel to SampleTypes::types
  /// Records only, per pixel or empty: the pixel's coverage where a budget may have left it without
  /// records (empty: the sum of its weights).
  std::vector<float> coverage;
  /// Records only, per pixel or empty: the RMS over RGB and over lights held back from the fit of
  /// what reduction changed, unshadowed, in the units of the picture.
  std::vector<float> predicted_error;
  /// Per pixel: the mean over its samples, misses included, of what their materials emit. Empty
  /// where the scene has no such material.
  std::vector<vec3> emission;
  bool has_footprints = false;  ///< rows have them, whether there are rows or not
  bool has_members = false;     ///< rows of two or more samples may have stored members

  int pixel_count() const { return width * height; }
  size_t row_count() const {
    size_t count = 0;
    for (const TypedRows& rows : types) count += rows.rows();
    return count;
  }
};

}  // namespace relume

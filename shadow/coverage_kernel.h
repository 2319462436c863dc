#pragma once

#include <cstdint>

#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int coverage_lanes = 16;  ///< receivers of a block

/// What a block stores per receiver, 16 lanes each. u and v are the light's picture plane, z the
/// depth from it; the footprint is the image of the square [-1, 1]^2 under (l0, 0; l1, l2), with
/// the depth z + zu (u - u0) + zv (v - v0) and a spread of depths around it.
enum CoverageArray {
  array_u,
  array_v,
  array_z,
  array_zu,
  array_zv,
  array_reach_u,   ///< half the footprint's extent in u,
  array_reach_v,   ///< in v
  array_far,       ///< and the farthest depth that an occluder in front of it may have
  array_size,      ///< root of three times the covariance's trace, over w
  array_softness,  ///< 1 / (2 half the spread): occluders are counted from -1/2 to 1/2 of it
  array_l0,
  array_l1,
  array_l2,
  array_m0,       ///< 1 / l0
  array_m2,       ///< 1 / l2
  array_piece,    ///< tag of the piece that the receiver lies on, or -1
  array_own_u,    ///< a point of the receiver on that piece,
  array_own_v,    ///< and,
  array_own_z,    ///< moved towards the light, its depth
  array_visible,  ///< out: product over the pieces before the last
  array_front,    ///< covered by the last piece's parts that wind one way,
  array_back,     ///< and the other
  coverage_arrays
};
inline constexpr int coverage_block_floats = coverage_arrays * coverage_lanes;

/// Pieces are told apart by a number that a float holds exactly. Pieces of a very large scene may
/// share one: then a receiver's footprint counts as a point for one piece too many.
inline float piece_tag(uint32_t piece) {
  return static_cast<float>(piece & 0xffffffu);
}

/// A receiver of the rasteriser, in a space where all lie within the unit sphere.
struct CoverageReceiver {
  float position[3] = {};        ///< mean of the samples
  float covariance[6] = {};      ///< xx, xy, xz, yy, yz, zz, with the sampling cell
  float bias = 0;                ///< how far towards the light occluders do not count
  float margin = 0;              ///< 1 on surfaces: their own spread does not count; 0 on strands
  float piece = -1;              ///< tag of the piece that it lies on, or -1
  float anchor[3] = {};          ///< a sample, which does lie on that piece
  float anchor_bias = 0;         ///< how far towards the light that piece does not count
  int16_t normal[3] = {};        ///< that light is judged by, times 32767; zero on strands
  int16_t plane[3] = {};         ///< of the geometry, times 32767, within 90 degrees of `normal`
  uint32_t lit_from_behind = 0;  ///< 0: light from behind `normal` does not count
};

/// A projective view from the light: (x, y, d) = rows * (p, 1), w = 1 + k d, then u = x / w,
/// v = y / w, z = d / w. k = 0 is parallel light.
struct CoverageView {
  float row[3][4];
  float k;
};

/// Bounds of blocks, in arrays.
struct CoverageBounds {
  float* u_low;
  float* u_high;
  float* v_low;
  float* v_high;
  float* z_high;    ///< farthest depth that an occluder in front of may count
  float* size_low;  ///< size of the smallest footprint, in all directions together
};

/// A hair segment or a triangle in a view.
struct CoveragePrimitive {
  float u[3];
  float v[3];
  float z[3];
  float opacity;   ///< of a triangle, (0, 1]; 0 = a segment: u[2] and v[2] are its half widths
  uint32_t piece;  ///< parts of one piece do not overlap
  bool is_sheet;   ///< nor do those that wind one way and those that wind the other
  bool has_plane;  ///< depth is plane[0] u + plane[1] v + plane[2]; else as at the corners
  float plane[3];
  float slack;  ///< how far its own receivers' piece may lie off: see ThinLevel
};

/// Blocks and what may shade them.
struct CoverageTask {
  float* blocks;
  CoverageBounds bounds;
  int block_count;
  const CoveragePrimitive* primitives;
  const uint32_t* order;  ///< indices of primitives, pieces together
  uint64_t count;
  uint64_t tests;  ///< out: receivers x primitives that were looked at
};

/// What bounds of a block that went dark say of its depth.
inline constexpr float dark_depth = -3e38f;

/// Below this visibility a receiver counts as dark.
inline constexpr float dark_visibility = 1.0f / 512;

struct CoverageKernels {
  /// Fills one block, and its bounds, from receivers index[0, count), 1 to 16 of them.
  void (*project)(const CoverageReceiver*, const CoverageView&, const uint32_t* index, int count,
                  float* block, const CoverageBounds& bounds);
  /// Multiplies the blocks' visibility by what the primitives leave; then front and back are used.
  void (*shade)(CoverageTask&);
};

/// The kernels of `set` (already chosen, not automatic).
CoverageKernels coverage_kernels(InstructionSet set);

namespace scalar {
CoverageKernels make_coverage_kernels();
}
namespace sse42 {
CoverageKernels make_coverage_kernels();
}
namespace avx2 {
CoverageKernels make_coverage_kernels();
}
namespace avx512 {
CoverageKernels make_coverage_kernels();
}

}  // namespace relume

#pragma once

#include <cstdint>

#include "core/simd/instruction_set.h"

namespace relume {

inline constexpr int coverage_lanes = 16;        ///< receivers of a block
inline constexpr int max_task_blocks = 64;       ///< of a leaf
inline constexpr int coverage_group_blocks = 8;  ///< blocks that are culled together

/// What a block stores per receiver, 16 lanes each. u and v are the light's picture plane, z the
/// depth from it; the footprint is the image of the square [-1, 1]^2 under (l0, 0; l1, l2), with
/// the depth z + zu (u - u0) + zv (v - v0) and a spread of depths around it.
enum CoverageArray {
  array_u,
  array_v,
  array_z,
  array_zu,
  array_zv,
  array_softness,  ///< 1 / (2 half the spread): occluders are counted from -1/2 to 1/2 of it
  array_l0,
  array_l1,
  array_l2,
  array_piece,    ///< tag of the piece of geometry that the receiver lies on, or -1
  array_visible,  ///< out: product over the pieces that were drawn
  coverage_arrays
};
inline constexpr int coverage_block_floats = coverage_arrays * coverage_lanes;

/// Pieces are told apart by a number that a float holds exactly. Pieces of a very large scene may
/// share one: then a receiver's footprint counts as a point for one piece too many.
inline float piece_tag(uint32_t piece) {
  return static_cast<float>(piece & 0xffffffu);
}

/// A receiver of the rasteriser, in a space where all lie within the unit sphere; a cache line.
struct alignas(64) CoverageReceiver {
  float position[3] = {};        ///< mean of the samples
  float covariance[6] = {};      ///< xx, xy, xz, yy, yz, zz, with the sampling cell
  float bias = 0;                ///< how far towards the light occluders do not count
  float margin = 0;              ///< 1 on surfaces: their own spread does not count; 0 on strands
  float piece = -1;              ///< tag of the piece that it lies on, or -1
  int16_t normal[3] = {};        ///< that light is judged by, times 32767; zero on strands
  int16_t plane[3] = {};         ///< of the geometry, times 32767, within 90 degrees of `normal`
  uint16_t lit_from_behind = 0;  ///< 0: light from behind `normal` does not count
  uint16_t has_back = 0;         ///< 1: a body, which hides it from light from behind
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

/// A hair segment in a view.
struct CoverageSegment {
  float u, v, z;  ///< where it starts
  float du, dv;   ///< unit, along it
  float length;
  float half, half_slope;  ///< half its width, and that over the length
  float z_slope;
  float z_low;
  float half_high;  ///< the widest half
  uint32_t piece;   ///< parts of one piece do not overlap
};

/// A triangle in a view.
struct CoverageTriangle {
  float u[3];
  float v[3];
  float z, zu, zv;  ///< plane: z at the first corner, and slopes
  float z_low, z_high;
  float slack;  ///< in depth: how far its own receivers' piece may lie off, see ThinLevel
  float opacity;
  uint32_t piece;     ///< parts of one piece do not overlap
  uint32_t is_sheet;  ///< nor do those that wind one way and those that wind the other
};

/// Primitives of one kind that may shade a leaf; a piece is never split between lists.
template <class Primitive>
struct CoverageList {
  const Primitive* primitives;
  const uint32_t* order;  ///< indices of primitives, pieces together
  uint64_t count;
};

/// The blocks of a leaf.
struct CoverageTask {
  float* blocks;
  CoverageBounds bounds;
  int block_count;  ///< up to max_task_blocks
  uint64_t tests;   ///< out: receivers x primitives that were looked at
};

/// What bounds of a block that went dark say of its depth.
inline constexpr float dark_depth = -3e38f;

/// Below this visibility a receiver counts as dark.
inline constexpr float dark_visibility = 1.0f / 512;

struct CoverageKernels {
  /// Fills one block, and its bounds, from receivers index[0, count), 1 to 16 of them.
  void (*project)(const CoverageReceiver*, const CoverageView&, const uint32_t* index, int count,
                  float* block, const CoverageBounds& bounds);
  /// Multiply the blocks' visibility by what the primitives leave.
  void (*shade_segments)(CoverageTask&, const CoverageList<CoverageSegment>*, int list_count);
  void (*shade_triangles)(CoverageTask&, const CoverageList<CoverageTriangle>*, int list_count);
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

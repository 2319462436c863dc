#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "shadow/strips.h"

namespace relume {

/// How finely thin geometry is cut into cells. A cell costs 4 bytes, one that holds geometry 14
/// more. Strands are far thinner than any cell: more cells cost time and tell no more about them.
/// Leaves are not, and gain.
struct VolumeParams {
  uint64_t max_cells = 8'000'000;         ///< empty ones included
  uint64_t max_strand_cells = 1'000'000;  ///< where all thin geometry is strands
  uint64_t max_occupied = 5'000'000;      ///< that hold geometry; the grid coarsens to stay below
  float gap = 0.25f;                      ///< cells along the ray that a receiver does not see
};

/// How much more than its area a piece of `width` x `length` cells counts for, >= 1: where it is
/// met it fills C = width / (width + 1) * length / (length + 1) of a cell's face, and what it lets
/// pass there, 1 - C, must come out of cells that multiply about exp(-area): -ln(1 - C) / C.
float clumping(float width, float length);

/// The projected area of thin geometry, cell by cell, for any direction: light-independent, built
/// once a scene. A cell's area seen along the unit vector w is sqrt(area * w^T Q w), in units of a
/// cell face: exact where the cell's pieces face one way, at most 4 % (strands) or 15 % (leaves)
/// too large where they face all ways. Q = sum of area (I - t t^T) over strands of tangent t, area
/// n n^T over triangles of normal n (compare Heitz et al., "The SGGX microflake distribution",
/// SIGGRAPH 2015). Adding a piece never lowers an area.
struct VolumeGrid {
  vec3 origin{0};             ///< world, low corner
  float cell = 1;             ///< world, side
  std::array<int, 3> size{};  ///< cells by axis, multiples of volume_alignment
  std::vector<uint32_t>
      occupied;             ///< cells with geometry, ascending: (z * size_y + y) * size_x + x
  std::vector<float> area;  ///< parallel: total area, each piece's times its clumping
  std::vector<std::array<int8_t, 6>> moments;  ///< parallel: Q / area * 127: xx yy zz xy xz yz

  uint64_t cell_count() const { return uint64_t{1} * size[0] * size[1] * size[2]; }
  size_t memory_bytes() const;
};

/// Sizes are multiples of this, so that coarser levels have whole cells.
inline constexpr int volume_alignment = 16;

/// Cuts the thin geometry of a scene. `region` empty: its bounds. Deterministic, all threads.
VolumeGrid make_volume_grid(const SceneStrips& thin, const VolumeParams& params,
                            const Bounds& region = {});

}  // namespace relume

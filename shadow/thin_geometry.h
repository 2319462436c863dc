#pragma once

#include <memory>
#include <vector>

#include "core/scene/scene.h"

namespace relume {

/// Triangles or hair segments that hang together: a leaf, a blade, a stem, a strand.
struct ThinPiece {
  uint32_t first_vertex = 0;
  uint32_t vertex_count = 0;
  uint32_t first_triangle = 0;  ///< of meshes
  uint32_t triangle_count = 0;
};

/// Pieces next to each other, a unit of work.
struct ThinChunk {
  uint32_t first_piece = 0;
  uint32_t piece_count = 0;
  uint32_t primitive_count = 0;
  Bounds bounds;  ///< local, strand radii included
};

/// The thin pieces of one shape, in its local space, stored once however often it is placed.
struct ThinShape {
  bool is_strands = false;
  std::vector<vec4> vertices;    ///< piece by piece; w = radius of strands
  std::vector<uvec3> triangles;  ///< indices into vertices
  std::vector<float> opacity;    ///< per triangle, (0, 1]; empty = all 1
  std::vector<ThinPiece> pieces;
  std::vector<ThinChunk> chunks;
};

/// A shape where it stands.
struct ThinInstance {
  uint32_t shape = 0;
  uint32_t first_piece = 0;  ///< number of its first piece among all of the scene
  mat4x3 world_from_local = identity_transform();
};

/// What the software rasteriser draws, and what is left for rays.
struct ThinGeometry {
  std::vector<ThinShape> shapes;
  std::vector<ThinInstance> instances;
  Scene solids;  ///< the rest: geometry, and the materials it needs for cut-outs

  bool empty() const { return instances.empty(); }
};

/// Splits a scene. Strands are thin. A connected piece of a mesh is thin when its mean width, area
/// over diameter, is below `max_width_px` pixels of a picture of `height_px` pixels where the
/// median instance of its prototype stands. A thin triangle whose material is a cut-out counts by
/// the part of it that the mask leaves.
ThinGeometry make_thin_geometry(const Scene& scene, int height_px, float max_width_px = 32);

}  // namespace relume

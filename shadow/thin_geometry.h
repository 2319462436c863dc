#pragma once

#include <memory>
#include <vector>

#include "core/base/bytes_of.h"
#include "core/scene/scene.h"
#include "core/trace/tracer.h"

namespace relume {

/// Triangles or hair segments that hang together: a leaf, a blade, a stem, a strand.
struct ThinPiece {
  uint32_t first_vertex = 0;
  uint32_t vertex_count = 0;
  uint32_t first_triangle = 0;  ///< of meshes
  uint32_t triangle_count = 0;
  bool is_sheet = false;  ///< of meshes: open, so that a line meets it once, not twice as a tube
};

/// A triangle of a mesh that belongs to no piece.
inline constexpr uint32_t no_piece = 0xffffffffu;

/// Pieces next to each other, a unit of work.
struct ThinChunk {
  uint32_t first_piece = 0;
  uint32_t piece_count = 0;
  uint32_t primitive_count = 0;
  Bounds bounds;  ///< local, strand radii included
};

/// A coarser form of a shape of triangles: the same pieces in the same order.
struct ThinLevel {
  std::vector<float> error;  ///< local, per piece: how far its surface lies from the shape's
  std::vector<vec4> vertices;
  std::vector<uvec3> triangles;
  std::vector<float> opacity;  ///< above 1 where area was lost
  std::vector<ThinPiece> pieces;
};

/// The thin pieces of one shape, in its local space, stored once however often it is placed.
struct ThinShape {
  bool is_strands = false;
  std::vector<vec4> vertices;    ///< piece by piece; w = radius of strands
  std::vector<uvec3> triangles;  ///< indices into vertices
  std::vector<float> opacity;    ///< per triangle, (0, 1]; empty = all 1
  std::vector<ThinPiece> pieces;
  std::vector<ThinChunk> chunks;
  std::vector<ThinLevel> levels;   ///< of triangles: coarser and coarser, may be empty
  std::vector<uint32_t> piece_of;  ///< per triangle of the scene's mesh, or no_piece
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

  std::vector<uint32_t> first_instance;         ///< per instance of the scene: its first one here
  std::vector<std::vector<uint32_t>> shape_of;  ///< per prototype and shape: which of its thin ones

  bool empty() const { return instances.empty(); }
  uint64_t memory_bytes() const;  ///< of what is drawn

  /// The number of the piece of a mesh that a point of the scene lies on, or no_piece.
  uint32_t piece_at(const Scene& scene, const SurfacePoint& point) const;
};

/// Splits a scene. Strands are thin. A connected piece of a mesh is thin when its mean width, area
/// over diameter, is below `max_width_px` pixels of a picture of `height_px` pixels where the
/// median instance of its prototype stands. A thin triangle whose material is a cut-out counts by
/// the part of it that the mask leaves.
///
/// Where all that is not thin has at most `drawn_triangles` triangles, those without a mask are
/// drawn like thin pieces.
ThinGeometry make_thin_geometry(const Scene& scene, int height_px, float max_width_px = 32,
                                uint64_t drawn_triangles = 0);

}  // namespace relume

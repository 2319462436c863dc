#pragma once

#include <functional>

#include "core/scene/scene.h"

namespace relume {

// What shadow methods that never ask the ray tracer take from a scene: its geometry in two kinds.
// Thin geometry is averaged (fractional coverage); solids are answered exactly, by rays.

/// A thin piece of geometry in world space: a straight piece of a strand, or a triangle.
struct ThinPiece {
  vec3 p0;
  vec3 p1;
  vec3 p2;         ///< triangles
  float r0 = 0;    ///< strands: radius at p0; 0 for triangles
  float r1 = 0;    ///< strands: radius at p1
  float fill = 1;  ///< triangles: the fraction that a cut-out leaves

  bool is_strand() const { return r0 > 0 || r1 > 0; }
};

/// Strands in world space, strands that start near each other stored near each other.
struct StrandSet {
  std::vector<vec4> points;        ///< strand after strand, root to tip: position, radius
  std::vector<uint32_t> segments;  ///< first point of each segment, ascending; the next one ends it
};

/// Prototypes placed so often count as thin, whatever their material: stems, pebbles, whole trees.
inline constexpr uint64_t thin_copies = 4;

/// Which triangles and strands of a scene are thin: strands, triangles of materials that transmit
/// light or have a cut-out mask, and all of a prototype that is placed thin_copies times or more.
class ThinGeometry {
 public:
  /// Keeps a reference to `scene`, which must outlive it.
  explicit ThinGeometry(const Scene& scene);

  /// World bounds of all thin pieces, radii included; empty when there are none.
  const Bounds& bounds() const { return bounds_; }
  bool empty() const { return bounds_.empty(); }
  /// Number of pieces as rays see them.
  uint64_t count() const { return count_; }

  size_t instance_count() const { return scene_.instances.size(); }
  /// World bounds of the thin pieces of an instance; empty when it has none.
  const Bounds& instance_bounds(size_t instance) const { return instance_bounds_[instance]; }
  /// Calls visit for each thin piece of an instance, in order. Thread-safe.
  template <class Visit>
  void visit(size_t instance, const Visit& visit) const;

  /// The strands of all instances, and which instances have thin triangles.
  StrandSet strands() const;
  bool has_triangles(size_t instance) const {
    return has_triangles_[scene_.instances[instance].prototype];
  }

  /// The scene's other geometry, without textures: what solid shadows are traced against. Has no
  /// instance when there is none.
  Scene solids() const;

 private:
  bool is_thin(const Mesh& mesh, size_t triangle, bool many) const;

  const Scene& scene_;
  std::vector<bool> has_triangles_;   ///< per prototype: thin ones
  std::vector<bool> many_;            ///< per prototype: placed often
  std::vector<float> material_fill_;  ///< per material: mean of its cut-out mask
  std::vector<bool> material_thin_;
  std::vector<Bounds> instance_bounds_;
  Bounds bounds_;
  uint64_t count_ = 0;
};

inline bool ThinGeometry::is_thin(const Mesh& mesh, size_t triangle, bool many) const {
  return many || material_thin_[mesh.materials[triangle]];
}

template <class Visit>
void ThinGeometry::visit(size_t instance, const Visit& visit) const {
  const Instance& placed = scene_.instances[instance];
  const mat4x3& m = placed.world_from_local;
  const bool many = many_[placed.prototype];
  for (const auto& shape : scene_.prototypes[placed.prototype].shapes) {
    if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
      for (size_t t = 0; t < mesh->triangles.size(); ++t) {
        if (!is_thin(*mesh, t, many)) continue;
        const uvec3 corner = mesh->triangles[t];
        visit(ThinPiece{transform_point(m, mesh->positions[corner.x]),
                        transform_point(m, mesh->positions[corner.y]),
                        transform_point(m, mesh->positions[corner.z]), 0, 0,
                        material_fill_[mesh->materials[t]]});
      }
      continue;
    }
    const Curves& curves = std::get<Curves>(shape);
    const float scale = uniform_scale(m);
    for (size_t strand = 0; strand + 1 < curves.offsets.size(); ++strand) {
      for (uint32_t p = curves.offsets[strand]; p + 1 < curves.offsets[strand + 1]; ++p) {
        const vec4 a = curves.points[p];
        const vec4 b = curves.points[p + 1];
        visit(ThinPiece{transform_point(m, vec3(a)), transform_point(m, vec3(b)), vec3(0),
                        scale * a.w, scale * b.w});
      }
    }
  }
}

}  // namespace relume

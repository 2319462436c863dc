#pragma once

#include <functional>

#include "core/scene/scene.h"

namespace relume {

// What shadow methods that never ask the ray tracer take from a scene: its geometry in two kinds.
// Thin geometry is averaged (fractional coverage); solids are answered exactly, by rays.

/// A thin piece of geometry in world space: a straight piece of a strand, or a triangle.
struct Strip {
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

  uint64_t memory_bytes() const {
    return points.size() * sizeof(vec4) + segments.size() * sizeof(uint32_t);
  }
};

/// Prototypes placed so often count as thin, whatever their material: stems, pebbles, whole trees.
inline constexpr uint64_t thin_copies = 4;

/// Which triangles and strands of a scene are thin: strands, triangles of materials that transmit
/// light or have a cut-out mask, and all of a prototype that is placed thin_copies times or more.
class SceneStrips {
 public:
  /// Keeps a reference to `scene`, which must outlive it. `all`: every triangle counts as thin.
  explicit SceneStrips(const Scene& scene, bool all = false);

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

  /// Triangles of an instance's meshes, thin ones or not, and the thin ones among [first, end).
  uint32_t triangle_count(size_t instance) const {
    return triangles_[scene_.instances[instance].prototype];
  }
  template <class Visit>
  void visit_triangles(size_t instance, uint32_t first, uint32_t end, const Visit& visit) const;

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
  std::vector<uint32_t> triangles_;   ///< per prototype: all
  std::vector<bool> many_;            ///< per prototype: placed often
  std::vector<float> material_fill_;  ///< per material: mean of its cut-out mask
  std::vector<bool> material_thin_;
  std::vector<Bounds> instance_bounds_;
  Bounds bounds_;
  uint64_t count_ = 0;
};

inline bool SceneStrips::is_thin(const Mesh& mesh, size_t triangle, bool many) const {
  return many || material_thin_[mesh.materials[triangle]];
}

template <class Visit>
void SceneStrips::visit_triangles(size_t instance, uint32_t first, uint32_t end,
                                  const Visit& visit) const {
  const Instance& placed = scene_.instances[instance];
  const mat4x3& m = placed.world_from_local;
  const bool many = many_[placed.prototype];
  uint32_t passed = 0;
  for (const auto& shape : scene_.prototypes[placed.prototype].shapes) {
    const Mesh* mesh = std::get_if<Mesh>(&shape);
    if (mesh == nullptr) continue;
    const auto count = static_cast<uint32_t>(mesh->triangles.size());
    const uint32_t low = std::min(count, first > passed ? first - passed : 0);
    const uint32_t high = std::min(count, end > passed ? end - passed : 0);
    for (uint32_t t = low; t < high; ++t) {
      if (!is_thin(*mesh, t, many)) continue;
      const uvec3 corner = mesh->triangles[t];
      visit(Strip{transform_point(m, mesh->positions[corner.x]),
                  transform_point(m, mesh->positions[corner.y]),
                  transform_point(m, mesh->positions[corner.z]), 0, 0,
                  material_fill_[mesh->materials[t]]});
    }
    passed += count;
  }
}

template <class Visit>
void SceneStrips::visit(size_t instance, const Visit& visit) const {
  visit_triangles(instance, 0, triangle_count(instance), visit);
  const Instance& placed = scene_.instances[instance];
  const mat4x3& m = placed.world_from_local;
  const float scale = uniform_scale(m);
  for (const auto& shape : scene_.prototypes[placed.prototype].shapes) {
    const Curves* curves = std::get_if<Curves>(&shape);
    if (curves == nullptr) continue;
    for (size_t strand = 0; strand + 1 < curves->offsets.size(); ++strand) {
      for (uint32_t p = curves->offsets[strand]; p + 1 < curves->offsets[strand + 1]; ++p) {
        const vec4 a = curves->points[p];
        const vec4 b = curves->points[p + 1];
        visit(Strip{transform_point(m, vec3(a)), transform_point(m, vec3(b)), vec3(0), scale * a.w,
                    scale * b.w});
      }
    }
  }
}

}  // namespace relume

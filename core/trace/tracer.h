#pragma once

#include <memory>
#include <optional>

#include "core/base/progress.h"
#include "core/scene/scene.h"

namespace relume {

struct Ray {
  vec3 origin;  ///< world
  float t_near = 0;
  vec3 direction;  ///< world; t counts in its length
  float t_far = std::numeric_limits<float>::infinity();
};

/// Where a view ray met the scene, with all that a material may need.
struct SurfacePoint {
  vec3 position;          ///< world; on strands the point of the axis that was met
  vec3 geometric_normal;  ///< unit, world, faces the ray's origin; zero on strands
  vec3 shading_normal;    ///< unit, world, faces the ray's origin
  vec3 tangent;           ///< unit, world, root to tip, on strands; zero on surfaces
  vec2 uv{0};
  vec3 color_scale{1};     ///< per-strand colour, multiplies "diffuse"
  uint32_t material = 0;   ///< index into Scene::materials
  float bias = 0;          ///< world units, see core/trace/ray_bias.h
  uint32_t instance = 0;   ///< index into Scene::instances
  uint32_t shape = 0;      ///< of the instance's prototype
  uint32_t primitive = 0;  ///< triangle, or segment in the strands' order
};

struct TracerStats {
  double build_ms = 0;
  uint64_t memory_bytes = 0;  ///< acceleration structures and copied vertices
  bool flattened = false;     ///< instances were flattened into one level
  uint64_t flattened_triangles = 0;
};

/// The ray tracer over one scene: the only Embree in the program. Strands are flat linear curves;
/// alpha cut-outs are respected by view and shadow rays alike. Immutable after construction;
/// queries are thread-safe and do not allocate. Keeps a reference to the scene, which must outlive
/// it.
class Tracer {
 public:
  explicit Tracer(const Scene& scene);
  ~Tracer();
  Tracer(Tracer&&) noexcept;

  /// The first surface along the ray, or nothing.
  std::optional<SurfacePoint> intersect(const Ray& ray) const;

  /// True when anything opaque lies on the ray between t_near and t_far.
  bool occluded(const Ray& ray) const;

  /// The scene it was made for.
  const Scene& scene() const;
  const TracerStats& stats() const;
  /// World bounds of everything that can be hit.
  const Bounds& bounds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace relume

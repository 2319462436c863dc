#pragma once

#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "core/image/image.h"
#include "core/relight/visibility.h"
#include "core/samples/relight_cache.h"
#include "core/samples/sample_scene.h"
#include "core/scene/scene.h"
#include "core/trace/tracer.h"

// Scenes small enough to have a closed-form answer, built by hand.

namespace relume::test {

/// A camera at `eye` that looks at `target`.
Camera make_camera(vec3 eye, vec3 target, float fov_y_deg, vec3 up = {0, 1, 0});

/// No geometry, no material, no light; the shader table is the program's.
Scene make_empty_scene(const Camera& camera, int width, int height);

/// Adds a material and returns its index.
uint32_t add_material(Scene& scene, std::string_view shader,
                      const std::vector<std::pair<std::string_view, vec3>>& values = {});

/// Adds `shape` as a prototype of its own, placed once.
void add_shape(Scene& scene, std::variant<Mesh, Curves> shape,
               const mat4x3& world_from_local = identity_transform());

/// The parallelogram center +- half_u +- half_v, two triangles, normal along cross(u, v), uv in
/// [0,1].
Mesh make_quad(vec3 center, vec3 half_u, vec3 half_v, uint32_t material);

/// A sphere of latitude bands with the exact (outward) normals of the sphere at its vertices.
Mesh make_sphere(vec3 center, float radius, int rings, uint32_t material);

/// One straight strand of equal segments and constant radius.
Curves make_strand(vec3 root, vec3 tip, float radius, int segments, uint32_t material);

/// A plane z = 0, 2 `half_size` wide, Lambert of albedo `albedo`, seen from (0, 0, 4) with a field
/// of view that it overfills.
Scene make_plane_scene(float half_size, vec3 albedo, int width, int height);

Light make_point_light(vec3 position, float gain = 1, bool falloff = true);
Light make_spot_light(vec3 position, vec3 direction, float inner_deg, float outer_deg,
                      bool falloff = true);
Light make_directional_light(vec3 direction, float gain = 1);

/// The transform x -> scale * x + offset.
mat4x3 make_similarity(float scale, vec3 offset = vec3(0));

/// `scene` with every coordinate and radius, camera and lights included, mapped to
/// scale * x + offset; gains of lights with falloff grow by scale^2, so that radiance stays.
Scene move_scene(const Scene& scene, float scale, vec3 offset);

/// What the cache's header says for a view that was not reduced.
CacheInfo make_cache_info(const Scene& scene, const SampleTypes& types, int spp, uint64_t seed);

/// Every sample of the scene's own view as a record.
RelightCache make_full_cache(const Scene& scene, const Tracer& tracer, int spp, uint64_t seed = 1);

/// The frame of `cache` under its own scene's lights.
Image render_frame(const RelightCache& cache, std::span<const Light> lights,
                   VisibilitySource* shadows = nullptr);

/// Largest absolute difference of any two values; images of equal size.
float max_difference(const Image& a, const Image& b);

}  // namespace relume::test

#pragma once

#include "core/scene/scene.h"

namespace relume {

/// A point of a mesh: barycentric coordinates within one of its triangles.
struct MeshPoint {
  const Mesh& mesh;
  uvec3 corner;  ///< vertices of the triangle
  float u = 0;   ///< weight of the second
  float v = 0;   ///< weight of the third
  vec2 uv{0};    ///< texture coordinates
};

/// `normal` (unit, world, on the mesh's own side) as `map` turns it, unit; x and y of the map are
/// times `scale`. Where neither tangents nor texture coordinates tell where u and v point, it stays
/// as it is.
vec3 map_normal(const Texture& map, float scale, const MeshPoint& point,
                const mat4x3& world_from_local, vec3 normal);

}  // namespace relume

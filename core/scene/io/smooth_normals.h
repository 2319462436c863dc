#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace relume {

/// Shading normals of a triangle mesh that has none.
struct SmoothNormals {
  std::vector<vec3> normals;               ///< unit
  std::vector<uint32_t> normal_of_corner;  ///< 3 per triangle, index into normals
};

/// Corners at one vertex share a normal when a chain of triangles leads from one to the other over
/// edges that bend by less than `smooth_angle_deg`. The normal is the mean of the triangles'
/// normals, weighted by their angle at the vertex, so that it does not depend on how polygons were
/// cut (Thuermer and Wuethrich, "Computing vertex normals from polygonal facets", JGT 3(1), 1998).
/// Triangles must have area. O(n log n).
SmoothNormals make_smooth_normals(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                  float smooth_angle_deg);

}  // namespace relume

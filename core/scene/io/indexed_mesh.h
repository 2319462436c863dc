#pragma once

#include <vector>

#include "core/math/vec.h"

namespace relume {

/// Triangles as files have them. Normals and uvs are empty or parallel to positions.
struct IndexedMesh {
  std::vector<vec3> positions;
  std::vector<vec3> normals;  ///< as they stand, of any length
  std::vector<vec2> uvs;
  std::vector<uvec3> triangles;  ///< indices within positions
};

}  // namespace relume

#pragma once

#include <array>
#include <string>

#include "core/scene/io/indexed_mesh.h"
#include "core/scene/scene.h"

namespace relume {

/// Gathers many small shapes into few large ones: meshes that agree in having normals and texture
/// coordinates, and strands. Triangles without area, segments of zero length and strands of fewer
/// than two points are dropped (counted). Throws Error(limit), naming `place`, above the limits of
/// core/scene/limits.h, and Error(input) where a transform leads beyond them.
class ShapeCollector {
 public:
  /// Adds a mesh, transformed. Indices are within its positions.
  void add(const IndexedMesh& mesh, const mat4x3& transform, uint32_t material,
           const std::string& place);

  /// Adds a strand of points and radii, transformed.
  void add_strand(const std::vector<vec4>& points, const mat4x3& transform, uint32_t material,
                  const std::string& place);

  bool empty() const;

  /// What was gathered, as one thing that can be placed.
  Prototype take(std::string name);

 private:
  std::array<Mesh, 4> meshes_;  ///< by whether they have normals (1) and uvs (2)
  Curves strands_;
};

}  // namespace relume

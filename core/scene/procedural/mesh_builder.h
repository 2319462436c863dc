#pragma once

#include <span>

#include "core/scene/scene.h"

namespace relume {

/// Collects one mesh with normals and texture coordinates, triangle by triangle. Triangles without
/// area (core/scene/limits.h) are left out.
class MeshBuilder {
 public:
  explicit MeshBuilder(uint32_t material) : material_(material) {}

  /// The material of the triangles that follow.
  void set_material(uint32_t material) { material_ = material; }

  /// `normal` is made unit length. Returns the vertex's index.
  uint32_t add_vertex(vec3 position, vec3 normal, vec2 uv);
  void add_triangle(uint32_t a, uint32_t b, uint32_t c);

  /// The mesh so far, without the vertices that no triangle uses; the builder is empty afterwards.
  Mesh take();

 private:
  Mesh mesh_;
  uint32_t material_;
};

/// One cross-section of a plant part: where it is and how it lies. The three vectors are unit
/// length and orthogonal; normal = cross(side, tangent) is the upper face of a leaf.
struct Section {
  vec3 center;
  vec3 tangent;  ///< along the part
  vec3 side;     ///< to the right, seen along the tangent with the upper face up
  vec3 normal;
};

/// `segments` + 1 sections of a curve in the plane across `side`: it starts at `start` in
/// `direction` and turns by `bend_rad` towards cross(direction, side), more strongly near its end.
/// With side = cross(outward, up) a positive bend leads from up to outward to down.
std::vector<Section> trace_arc(vec3 start, vec3 direction, vec3 side, float length, float bend_rad,
                               int segments);

/// Relative width of a part at a fraction of its length, both in [0, 1].
using WidthProfile = float (*)(float along);

/// Broadest before the middle, pointed at both ends.
float ovate_profile(float along);
/// Broad from the base, tapering to a point.
float blade_profile(float along);
/// Narrow base, broadest near the rounded end: a petal.
float petal_profile(float along);

/// A leaf along `sections`: width * profile on both sides of a midrib, whose halves are raised by
/// `fold` (tangent of the angle, 0 = flat with no midrib).
void add_leaf(MeshBuilder& builder, std::span<const Section> sections, float half_width,
              WidthProfile profile, float fold);

/// A round tube along `sections` from `radius` to `radius` * `taper` (0 = a point), without caps.
void add_tube(MeshBuilder& builder, std::span<const Section> sections, float radius, float taper,
              int sides);

}  // namespace relume

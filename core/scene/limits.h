#pragma once

#include <cstdint>

#include "core/math/vec.h"

namespace relume {

// What a scene may hold. Loaders check these before they allocate; validate_scene checks them
// again.

inline constexpr int max_image_side = 16384;            ///< pixels
inline constexpr uint64_t max_triangles = 500'000'000;  ///< stored, summed over prototypes
inline constexpr uint64_t max_strands = 10'000'000;     ///< stored, summed over prototypes
inline constexpr uint64_t max_segments = 500'000'000;   ///< stored, summed over prototypes
inline constexpr uint64_t max_instances = 10'000'000;
inline constexpr uint64_t max_materials = 65'535;
inline constexpr uint64_t max_lights = 1024;
inline constexpr size_t max_name_length = 256;  ///< bytes

/// Largest absolute coordinate, local and world. Products of two edges, and their squares, then
/// stay within a float.
inline constexpr float max_coordinate = 1e9f;

/// Largest radiance that a material may emit.
inline constexpr float max_emission = 1e20f;

/// False when the triangle's height over its longest edge is below 1e-7 of that edge: a float
/// cannot tell such a triangle from a line, and it has no normal.
inline bool has_area(vec3 a, vec3 b, vec3 c) {
  const dvec3 ab = dvec3(b) - dvec3(a);
  const dvec3 ac = dvec3(c) - dvec3(a);
  const dvec3 bc = dvec3(c) - dvec3(b);
  const double longest_squared =
      std::max(glm::dot(ab, ab), std::max(glm::dot(ac, ac), glm::dot(bc, bc)));
  return glm::length(glm::cross(ab, ac)) > 1e-7 * longest_squared;
}

/// True when `p` is finite and within max_coordinate.
inline bool is_coordinate(vec3 p) {
  return is_finite(p) && max_abs_component(p) <= max_coordinate;
}

}  // namespace relume

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/vec.h"

namespace relume {

/// Concave polygons of more corners than this are refused: cutting them costs the cube of the
/// count.
inline constexpr size_t max_concave_corners = 1024;

/// Cuts a polygon of n >= 3 corners, flat or nearly so, into n - 2 triangles of its winding, as
/// indices into `corners`: quads along their shorter inner diagonal, convex polygons as a fan,
/// others by ear clipping in their own plane. What is left of a polygon that crosses itself becomes
/// a fan. False, with nothing appended, when it is concave and above max_concave_corners.
bool triangulate(std::span<const vec3> corners, std::vector<std::array<uint32_t, 3>>& triangles);

}  // namespace relume

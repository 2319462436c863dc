#include "core/scene/io/triangulate.h"

#include <numeric>

#include "core/base/check.h"
#include "core/math/frame.h"

namespace relume {
namespace {

double cross_2d(dvec2 a, dvec2 b) {
  return a.x * b.y - a.y * b.x;
}

/// Twice the signed area of a, b, c.
double area_2d(dvec2 a, dvec2 b, dvec2 c) {
  return cross_2d(b - a, c - a);
}

/// The corners in the polygon's own plane, counter-clockwise. Newell's normal is the area-weighted
/// one.
std::vector<dvec2> project(std::span<const vec3> corners) {
  const dvec3 origin(corners[0]);
  dvec3 normal(0);
  for (size_t i = 0; i < corners.size(); ++i) {
    const dvec3 a = dvec3(corners[i]) - origin;
    const dvec3 b = dvec3(corners[(i + 1) % corners.size()]) - origin;
    normal += glm::cross(a, b);
  }
  const vec3 unit = normalize_or(vec3(normal), vec3(0, 0, 1));
  const Frame frame = make_frame(unit);
  std::vector<dvec2> flat;
  flat.reserve(corners.size());
  for (const vec3 corner : corners) {
    const dvec3 v = dvec3(corner) - origin;
    flat.emplace_back(glm::dot(v, dvec3(frame.tangent)), glm::dot(v, dvec3(frame.bitangent)));
  }
  return flat;
}

bool is_convex(const std::vector<dvec2>& flat) {
  for (size_t i = 0; i < flat.size(); ++i) {
    const size_t next = (i + 1) % flat.size();
    if (area_2d(flat[i], flat[next], flat[(i + 2) % flat.size()]) < 0) return false;
  }
  return true;
}

void append_fan(const std::vector<uint32_t>& loop,
                std::vector<std::array<uint32_t, 3>>& triangles) {
  for (size_t i = 2; i < loop.size(); ++i) triangles.push_back({loop[0], loop[i - 1], loop[i]});
}

bool is_ear(const std::vector<dvec2>& flat, const std::vector<uint32_t>& loop, size_t tip) {
  const size_t n = loop.size();
  const dvec2 a = flat[loop[(tip + n - 1) % n]];
  const dvec2 b = flat[loop[tip]];
  const dvec2 c = flat[loop[(tip + 1) % n]];
  if (area_2d(a, b, c) <= 0) return false;
  for (size_t i = 0; i + 3 < n; ++i) {
    const dvec2 p = flat[loop[(tip + 2 + i) % n]];
    if (p == a || p == b || p == c) continue;
    if (area_2d(a, b, p) >= 0 && area_2d(b, c, p) >= 0 && area_2d(c, a, p) >= 0) return false;
  }
  return true;
}

void clip_ears(const std::vector<dvec2>& flat, std::vector<uint32_t>& loop,
               std::vector<std::array<uint32_t, 3>>& triangles) {
  size_t tip = 0;
  size_t tries = 0;
  while (loop.size() > 3 && tries < loop.size()) {
    const size_t n = loop.size();
    tip %= n;
    if (!is_ear(flat, loop, tip)) {
      ++tip;
      ++tries;
      continue;
    }
    triangles.push_back({loop[(tip + n - 1) % n], loop[tip], loop[(tip + 1) % n]});
    loop.erase(loop.begin() + static_cast<ptrdiff_t>(tip));
    tries = 0;
  }
}

void append_quad(std::span<const vec3> corners, const std::vector<dvec2>& flat,
                 std::vector<std::array<uint32_t, 3>>& triangles) {
  // A diagonal is inside when both halves keep the winding.
  const double half_a =
      std::min(area_2d(flat[0], flat[1], flat[2]), area_2d(flat[0], flat[2], flat[3]));
  const double half_b =
      std::min(area_2d(flat[0], flat[1], flat[3]), area_2d(flat[1], flat[2], flat[3]));
  const bool a_shorter = glm::length(dvec3(corners[2]) - dvec3(corners[0])) <=
                         glm::length(dvec3(corners[3]) - dvec3(corners[1]));
  const bool use_a = (half_a >= 0) == (half_b >= 0) ? a_shorter : half_a >= 0;
  if (use_a) {
    triangles.push_back({0, 1, 2});
    triangles.push_back({0, 2, 3});
  } else {
    triangles.push_back({0, 1, 3});
    triangles.push_back({1, 2, 3});
  }
}

}  // namespace

bool triangulate(std::span<const vec3> corners, std::vector<std::array<uint32_t, 3>>& triangles) {
  CHECK(corners.size() >= 3);
  if (corners.size() == 3) {
    triangles.push_back({0, 1, 2});
    return true;
  }
  const std::vector<dvec2> flat = project(corners);
  if (corners.size() == 4) {
    append_quad(corners, flat, triangles);
    return true;
  }
  std::vector<uint32_t> loop(corners.size());
  std::iota(loop.begin(), loop.end(), 0u);
  if (!is_convex(flat)) {
    if (corners.size() > max_concave_corners) return false;
    clip_ears(flat, loop, triangles);
  }
  append_fan(loop, triangles);
  return true;
}

}  // namespace relume

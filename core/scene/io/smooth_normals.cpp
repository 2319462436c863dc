#include "core/scene/io/smooth_normals.h"

#include <numeric>
#include <tuple>

namespace relume {
namespace {

/// Corner c of triangle t is number 3 t + c.
using Corner = uint64_t;

/// Disjoint sets of corners.
class CornerSets {
 public:
  explicit CornerSets(size_t count) : parents_(count) {
    std::iota(parents_.begin(), parents_.end(), Corner{0});
  }
  Corner find(Corner corner) {
    while (parents_[corner] != corner) {
      parents_[corner] = parents_[parents_[corner]];
      corner = parents_[corner];
    }
    return corner;
  }
  /// The smaller number stays the root, so that the result does not depend on the order of joins.
  void join(Corner a, Corner b) {
    a = find(a);
    b = find(b);
    if (a != b) parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<Corner> parents_;
};

/// A triangle's side: its two vertices in ascending order and the triangle's corners there.
struct Side {
  uint32_t low_vertex;
  uint32_t high_vertex;
  Corner low_corner;
  Corner high_corner;
};

std::vector<Side> make_sides(std::span<const uvec3> triangles) {
  std::vector<Side> sides;
  sides.reserve(triangles.size() * 3);
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (size_t c = 0; c < 3; ++c) {
      const size_t d = (c + 1) % 3;
      const uint32_t v = triangles[t][c];
      const uint32_t w = triangles[t][d];
      sides.push_back(v < w ? Side{v, w, 3 * t + c, 3 * t + d} : Side{w, v, 3 * t + d, 3 * t + c});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::tie(a.low_vertex, a.high_vertex, a.low_corner) <
           std::tie(b.low_vertex, b.high_vertex, b.low_corner);
  });
  return sides;
}

dvec3 unit(dvec3 v) {
  const double length = glm::length(v);
  return length > 0 ? v / length : dvec3(0);
}

std::vector<vec3> face_normals(std::span<const vec3> positions, std::span<const uvec3> triangles) {
  std::vector<vec3> normals;
  normals.reserve(triangles.size());
  for (const uvec3 t : triangles) {
    const dvec3 a(positions[t.x]);
    normals.emplace_back(unit(glm::cross(dvec3(positions[t.y]) - a, dvec3(positions[t.z]) - a)));
  }
  return normals;
}

/// The angle of triangle `t` at its corner `c`, radians.
double corner_angle(std::span<const vec3> positions, uvec3 t, size_t c) {
  const dvec3 p(positions[t[c]]);
  const dvec3 a = unit(dvec3(positions[t[(c + 1) % 3]]) - p);
  const dvec3 b = unit(dvec3(positions[t[(c + 2) % 3]]) - p);
  return std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0));
}

}  // namespace

SmoothNormals make_smooth_normals(std::span<const vec3> positions, std::span<const uvec3> triangles,
                                  float smooth_angle_deg) {
  const std::vector<vec3> faces = face_normals(positions, triangles);
  const std::vector<Side> sides = make_sides(triangles);
  CornerSets sets(triangles.size() * 3);
  const float smallest_cosine = std::cos(radians_from_degrees(smooth_angle_deg));
  for (size_t i = 1; i < sides.size(); ++i) {
    const Side& a = sides[i - 1];
    const Side& b = sides[i];
    if (a.low_vertex != b.low_vertex || a.high_vertex != b.high_vertex) continue;
    if (glm::dot(faces[a.low_corner / 3], faces[b.low_corner / 3]) <= smallest_cosine) continue;
    sets.join(a.low_corner, b.low_corner);
    sets.join(a.high_corner, b.high_corner);
  }
  SmoothNormals result;
  result.normal_of_corner.resize(triangles.size() * 3);
  std::vector<dvec3> sums;
  for (Corner corner = 0; corner < result.normal_of_corner.size(); ++corner) {
    const Corner root = sets.find(corner);  // never above corner
    const uint32_t id =
        root == corner ? static_cast<uint32_t>(sums.size()) : result.normal_of_corner[root];
    if (root == corner) sums.emplace_back(0);
    result.normal_of_corner[corner] = id;
    const size_t t = corner / 3;
    sums[id] += dvec3(faces[t]) * corner_angle(positions, triangles[t], corner % 3);
  }
  result.normals.reserve(sums.size());
  for (const dvec3 sum : sums) result.normals.push_back(normalize_or(vec3(sum), vec3(0)));
  // Faces that cancel each other: each corner keeps the normal of one of its faces.
  for (Corner corner = 0; corner < result.normal_of_corner.size(); ++corner) {
    vec3& normal = result.normals[result.normal_of_corner[corner]];
    if (normal == vec3(0)) normal = faces[corner / 3];
  }
  return result;
}

}  // namespace relume

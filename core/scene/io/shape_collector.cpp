#include "core/scene/io/shape_collector.h"

#include <fmt/format.h>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/math/transform.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

RareEvent dropped_triangles("imported triangles without area dropped");
RareEvent dropped_segments("imported segments of zero length dropped");
RareEvent dropped_strands("imported strands of fewer than two points or no thickness dropped");
RareEvent raised_widths("imported strands' width of zero raised");

vec3 place_point(const mat4x3& transform, vec3 p, const std::string& place) {
  const vec3 moved = transform_point(transform, p);
  if (is_coordinate(moved)) return moved;
  throw input_error(place, "its transform leads beyond 1e9", "check the transforms");
}

}  // namespace

void ShapeCollector::add(const IndexedMesh& mesh, const mat4x3& transform, uint32_t material,
                         const std::string& place) {
  std::vector<vec3> normals;
  for (const vec3 n : mesh.normals) {
    normals.push_back(normalize_or(transform_normal(transform, n), vec3(0)));
    if (normals.back() != vec3(0)) continue;
    normals.clear();  // one that says nothing: the faces' own are used
    break;
  }
  Mesh& target = meshes_[(normals.empty() ? 0 : 1) + (mesh.uvs.empty() ? 0 : 2)];
  if (target.positions.size() + mesh.positions.size() > UINT32_MAX ||
      target.triangles.size() + mesh.triangles.size() > max_triangles) {
    throw limit_error(place, "too many triangles", fmt::format("the limit is {}", max_triangles));
  }
  const auto first = static_cast<uint32_t>(target.positions.size());
  for (const vec3 p : mesh.positions) target.positions.push_back(place_point(transform, p, place));
  target.normals.insert(target.normals.end(), normals.begin(), normals.end());
  target.uvs.insert(target.uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
  for (const uvec3 t : mesh.triangles) {
    const uvec3 moved = t + first;
    const auto& p = target.positions;
    if (has_area(p[moved.x], p[moved.y], p[moved.z])) {
      target.triangles.push_back(moved);
      target.materials.push_back(material);
    } else {
      dropped_triangles.add();
    }
  }
}

void ShapeCollector::add_strand(const std::vector<vec4>& points, const mat4x3& transform,
                                uint32_t material, const std::string& place) {
  if (strands_.offsets.empty()) strands_.offsets.push_back(0);
  if (strands_.materials.size() >= max_strands ||
      strands_.points.size() + points.size() > max_segments) {
    throw limit_error(place, "too many strands or segments",
                      fmt::format("the limits are {} and {}", max_strands, max_segments));
  }
  const float scale = uniform_scale(transform);
  const size_t begin = strands_.points.size();
  float largest = 0;
  for (const vec4 point : points) {
    const vec3 p = place_point(transform, vec3(point), place);
    const float radius = point.w * scale;
    largest = std::max(largest, radius);
    if (strands_.points.size() > begin && vec3(strands_.points.back()) == p) {
      dropped_segments.add();
      continue;
    }
    strands_.points.emplace_back(p, radius);
  }
  // A tip may taper to nothing; a strand of ours may not.
  const float smallest = 0.01f * largest;
  if (strands_.points.size() < begin + 2 || !(smallest > 0 && largest <= max_coordinate)) {
    strands_.points.resize(begin);
    dropped_strands.add();
    return;
  }
  for (size_t i = begin; i < strands_.points.size(); ++i) {
    if (strands_.points[i].w > 0) continue;
    strands_.points[i].w = smallest;
    raised_widths.add();
  }
  strands_.offsets.push_back(static_cast<uint32_t>(strands_.points.size()));
  strands_.materials.push_back(material);
}

bool ShapeCollector::empty() const {
  return strands_.materials.empty() &&
         std::ranges::all_of(meshes_, [](const Mesh& mesh) { return mesh.triangles.empty(); });
}

Prototype ShapeCollector::take(std::string name) {
  Prototype prototype;
  prototype.name = std::move(name);
  for (Mesh& mesh : meshes_) {
    if (!mesh.triangles.empty()) prototype.shapes.emplace_back(std::move(mesh));
  }
  if (!strands_.materials.empty()) prototype.shapes.emplace_back(std::move(strands_));
  meshes_ = {};
  strands_ = {};
  return prototype;
}

}  // namespace relume

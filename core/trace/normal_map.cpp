#include "core/trace/normal_map.h"

#include "core/math/transform.h"
#include "core/trace/texture_lookup.h"

namespace relume {
namespace {

/// Where u and v point, world; zero where nothing tells.
struct UvAxes {
  vec3 u{0};
  vec3 v{0};
};

UvAxes axes_of_tangents(const MeshPoint& point, const mat4x3& world_from_local, vec3 normal) {
  const auto& tangents = point.mesh.tangents;
  const vec4 a = tangents[point.corner.x];
  const vec3 local = vec3(a) * (1 - point.u - point.v) + vec3(tangents[point.corner.y]) * point.u +
                     vec3(tangents[point.corner.z]) * point.v;
  const vec3 tangent = transform_vector(world_from_local, local);
  const mat4x3& m = world_from_local;
  const float side = glm::dot(m[0], glm::cross(m[1], m[2])) < 0 ? -a.w : a.w;
  return {tangent, glm::cross(normal, tangent) * side};
}

UvAxes axes_of_uvs(const MeshPoint& point, const mat4x3& world_from_local) {
  const Mesh& mesh = point.mesh;
  if (mesh.uvs.empty()) return {};
  const vec3 origin = mesh.positions[point.corner.x];
  const dvec3 p1(mesh.positions[point.corner.y] - origin);
  const dvec3 p2(mesh.positions[point.corner.z] - origin);
  const dvec2 uv1(mesh.uvs[point.corner.y] - mesh.uvs[point.corner.x]);
  const dvec2 uv2(mesh.uvs[point.corner.z] - mesh.uvs[point.corner.x]);
  const double area = uv1.x * uv2.y - uv2.x * uv1.y;
  const double size = glm::length(uv1) * glm::length(uv2);
  if (!(std::abs(area) > 1e-9 * size)) return {};
  const double sign = area < 0 ? -1 : 1;
  const dvec3 u = sign * (p1 * uv2.y - p2 * uv1.y);
  const dvec3 v = sign * (p2 * uv1.x - p1 * uv2.x);
  return {transform_vector(world_from_local, normalize_or(vec3(u), vec3(0))),
          transform_vector(world_from_local, normalize_or(vec3(v), vec3(0)))};
}

}  // namespace

vec3 map_normal(const Texture& map, float scale, const MeshPoint& point,
                const mat4x3& world_from_local, vec3 normal) {
  const UvAxes axes = point.mesh.tangents.empty()
                          ? axes_of_uvs(point, world_from_local)
                          : axes_of_tangents(point, world_from_local, normal);
  const vec3 tangent = normalize_or(axes.u - normal * glm::dot(normal, axes.u), vec3(0));
  if (tangent == vec3(0)) return normal;
  vec3 bitangent = glm::cross(normal, tangent);
  if (glm::dot(bitangent, axes.v) < 0) bitangent = -bitangent;
  const vec3 texel = 2.0f * vec3(lookup_texture(map, point.uv)) - 1.0f;
  return normalize_or(
      tangent * (texel.x * scale) + bitangent * (texel.y * scale) + normal * texel.z, normal);
}

}  // namespace relume

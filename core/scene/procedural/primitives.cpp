#include <array>

#include "core/base/check.h"
#include "core/scene/procedural/generators.h"
#include "core/scene/procedural/mesh_builder.h"

namespace relume {
namespace {

constexpr double double_pi = 3.14159265358979323846;

void add_quad(MeshBuilder& builder, vec3 center, vec3 right, vec3 up) {
  const vec3 normal = normalize_or(glm::cross(right, up), vec3(0, 1, 0));
  const uint32_t a = builder.add_vertex(center - right - up, normal, {0, 0});
  const uint32_t b = builder.add_vertex(center + right - up, normal, {1, 0});
  const uint32_t c = builder.add_vertex(center + right + up, normal, {1, 1});
  const uint32_t d = builder.add_vertex(center - right + up, normal, {0, 1});
  builder.add_triangle(a, b, c);
  builder.add_triangle(a, c, d);
}

bool is_positive(float x) {
  return x > 0 && is_finite(x);
}

}  // namespace

Mesh make_sphere(const SphereParams& params) {
  CHECK_MSG(is_finite(params.center) && is_positive(params.radius), "radius {}", params.radius);
  CHECK_MSG(params.rings >= 3 && params.rings <= 2048, "rings {}", params.rings);
  const int rings = params.rings;
  const int sectors = 2 * rings;
  MeshBuilder builder(params.material);
  for (int ring = 0; ring <= rings; ++ring) {
    const double latitude = double_pi * (0.5 - static_cast<double>(ring) / rings);
    const bool pole = ring == 0 || ring == rings;
    const double y = pole ? (ring == 0 ? 1.0 : -1.0) : std::sin(latitude);
    const double across = pole ? 0.0 : std::cos(latitude);
    for (int sector = 0; sector <= sectors; ++sector) {
      // The seam's two columns have the same bits.
      const double longitude = 2 * double_pi * (sector % sectors) / sectors;
      const vec3 normal(dvec3(across * std::cos(longitude), y, -across * std::sin(longitude)));
      builder.add_vertex(params.center + params.radius * normal, normal,
                         {static_cast<float>(sector) / static_cast<float>(sectors),
                          1 - static_cast<float>(ring) / static_cast<float>(rings)});
    }
  }
  const auto vertex = [&](int ring, int sector) {
    return static_cast<uint32_t>(ring * (sectors + 1) + sector);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int sector = 0; sector < sectors; ++sector) {
      const uint32_t a = vertex(ring, sector);
      const uint32_t b = vertex(ring + 1, sector);
      const uint32_t c = vertex(ring + 1, sector + 1);
      const uint32_t d = vertex(ring, sector + 1);
      if (ring < rings - 1) builder.add_triangle(a, b, c);
      if (ring > 0) builder.add_triangle(a, c, d);
    }
  }
  return builder.take();
}

Mesh make_plane(vec3 center, vec2 half_size, uint32_t material) {
  CHECK_MSG(is_finite(center) && is_positive(half_size.x) && is_positive(half_size.y),
            "half size {} x {}", half_size.x, half_size.y);
  MeshBuilder builder(material);
  add_quad(builder, center, {half_size.x, 0, 0}, {0, 0, -half_size.y});
  return builder.take();
}

Mesh make_box(vec3 center, vec3 half_size, uint32_t material) {
  CHECK_MSG(is_finite(center) && is_positive(half_size.x) && is_positive(half_size.y) &&
                is_positive(half_size.z),
            "half size {} x {} x {}", half_size.x, half_size.y, half_size.z);
  MeshBuilder builder(material);
  const vec3 x(half_size.x, 0, 0);
  const vec3 y(0, half_size.y, 0);
  const vec3 z(0, 0, half_size.z);
  add_quad(builder, center + x, -z, y);
  add_quad(builder, center - x, z, y);
  add_quad(builder, center + y, x, -z);
  add_quad(builder, center - y, x, z);
  add_quad(builder, center + z, x, y);
  add_quad(builder, center - z, -x, y);
  return builder.take();
}

}  // namespace relume

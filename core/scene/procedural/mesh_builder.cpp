#include "core/scene/procedural/mesh_builder.h"

#include <utility>

#include "core/base/check.h"
#include "core/math/frame.h"
#include "core/scene/limits.h"

namespace relume {

uint32_t MeshBuilder::add_vertex(vec3 position, vec3 normal, vec2 uv) {
  mesh_.positions.push_back(position);
  mesh_.normals.push_back(normalize_or(normal, vec3(0, 1, 0)));
  mesh_.uvs.push_back(uv);
  return static_cast<uint32_t>(mesh_.positions.size() - 1);
}

void MeshBuilder::add_triangle(uint32_t a, uint32_t b, uint32_t c) {
  DCHECK(std::max(a, std::max(b, c)) < mesh_.positions.size());
  if (!has_area(mesh_.positions[a], mesh_.positions[b], mesh_.positions[c])) return;
  mesh_.triangles.push_back({a, b, c});
  mesh_.materials.push_back(material_);
}

Mesh MeshBuilder::take() {
  constexpr uint32_t unused = ~0u;
  std::vector<uint32_t> renumbered(mesh_.positions.size(), unused);
  for (const uvec3& triangle : mesh_.triangles) {
    for (size_t c = 0; c < 3; ++c) renumbered[triangle[c]] = 0;
  }
  uint32_t kept = 0;
  for (size_t i = 0; i < renumbered.size(); ++i) {
    if (renumbered[i] == unused) continue;
    mesh_.positions[kept] = mesh_.positions[i];
    mesh_.normals[kept] = mesh_.normals[i];
    mesh_.uvs[kept] = mesh_.uvs[i];
    renumbered[i] = kept++;
  }
  mesh_.positions.resize(kept);
  mesh_.normals.resize(kept);
  mesh_.uvs.resize(kept);
  for (uvec3& triangle : mesh_.triangles) {
    for (size_t c = 0; c < 3; ++c) triangle[c] = renumbered[triangle[c]];
  }
  return std::exchange(mesh_, {});
}

std::vector<Section> trace_arc(vec3 start, vec3 direction, vec3 side, float length, float bend_rad,
                               int segments) {
  CHECK_MSG(segments >= 1 && length > 0, "segments {} length {}", segments, length);
  const vec3 unit_side = normalize_or(side, vec3(1, 0, 0));
  const vec3 forward = normalize_or(direction - unit_side * glm::dot(direction, unit_side),
                                    make_frame(unit_side).tangent);
  const vec3 bent = glm::cross(forward, unit_side);
  const auto tangent_at = [&](float along) {
    const float angle = bend_rad * 0.5f * along * (1 + along);
    return std::cos(angle) * forward + std::sin(angle) * bent;
  };
  const float step = length / static_cast<float>(segments);
  std::vector<Section> sections;
  sections.reserve(static_cast<size_t>(segments) + 1);
  vec3 center = start;
  for (int i = 0; i <= segments; ++i) {
    const float along = static_cast<float>(i) / static_cast<float>(segments);
    const vec3 tangent = tangent_at(along);
    sections.push_back({center, tangent, unit_side, glm::cross(unit_side, tangent)});
    center += step * tangent_at(along + 0.5f / static_cast<float>(segments));
  }
  return sections;
}

float ovate_profile(float along) {
  return std::sin(pi * std::pow(along, 0.75f));
}

float blade_profile(float along) {
  return 1 - along * along;
}

float petal_profile(float along) {
  return std::pow(std::sin(0.5f * pi * along), 1.2f) * 0.85f + 0.15f;
}

void add_leaf(MeshBuilder& builder, std::span<const Section> sections, float half_width,
              WidthProfile profile, float fold) {
  CHECK_MSG(sections.size() >= 2 && half_width > 0, "sections {} width {}", sections.size(),
            half_width);
  const bool has_midrib = fold != 0;
  std::vector<uint32_t> previous;
  for (size_t i = 0; i < sections.size(); ++i) {
    const Section& s = sections[i];
    const float along = static_cast<float>(i) / static_cast<float>(sections.size() - 1);
    const float width = half_width * std::max(0.0f, profile(along));
    // Without a midrib the normals lean outwards a little, as if the blade were rounded.
    const float lean = has_midrib ? -fold : 0.35f;
    std::vector<uint32_t> row;
    row.push_back(builder.add_vertex(s.center + width * (fold * s.normal - s.side),
                                     s.normal - lean * s.side, {0, along}));
    if (has_midrib) row.push_back(builder.add_vertex(s.center, s.normal, {0.5f, along}));
    row.push_back(builder.add_vertex(s.center + width * (fold * s.normal + s.side),
                                     s.normal + lean * s.side, {1, along}));
    for (size_t column = 0; i > 0 && column + 1 < row.size(); ++column) {
      builder.add_triangle(previous[column], previous[column + 1], row[column + 1]);
      builder.add_triangle(previous[column], row[column + 1], row[column]);
    }
    previous = std::move(row);
  }
}

void add_tube(MeshBuilder& builder, std::span<const Section> sections, float radius, float taper,
              int sides) {
  CHECK_MSG(sections.size() >= 2 && radius > 0 && sides >= 3, "sections {} radius {} sides {}",
            sections.size(), radius, sides);
  std::vector<uint32_t> previous;
  for (size_t i = 0; i < sections.size(); ++i) {
    const Section& s = sections[i];
    const float along = static_cast<float>(i) / static_cast<float>(sections.size() - 1);
    const float r = radius * (1 - along * (1 - taper));
    std::vector<uint32_t> row;
    for (int k = 0; k <= sides; ++k) {
      const float angle = 2 * pi * static_cast<float>(k % sides) / static_cast<float>(sides);
      const vec3 outward = std::cos(angle) * s.side + std::sin(angle) * s.normal;
      row.push_back(builder.add_vertex(s.center + r * outward, outward,
                                       {static_cast<float>(k) / static_cast<float>(sides), along}));
    }
    for (size_t k = 0; i > 0 && k + 1 < row.size(); ++k) {
      builder.add_triangle(previous[k], row[k + 1], previous[k + 1]);
      builder.add_triangle(previous[k], row[k], row[k + 1]);
    }
    previous = std::move(row);
  }
}

}  // namespace relume

#include "shadow/thin_geometry.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "core/trace/texture_lookup.h"
#include "shadow/morton.h"
#include "shadow/thin_levels.h"

namespace relume {
namespace {

constexpr uint32_t chunk_primitives = 512;
/// Points of a cut-out triangle that its mask is asked at: a lattice of this many rows.
constexpr int mask_rows = 6;

/// Disjoint sets of vertices.
class Components {
 public:
  explicit Components(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  uint32_t find(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The lower index stays the root, so that pieces keep the mesh's order.
  void join(uint32_t a, uint32_t b) {
    a = find(a);
    b = find(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

struct PositionHash {
  size_t operator()(const vec3& p) const {
    size_t h = 0;
    for (size_t i = 0; i < 3; ++i) h = h * 1000003u ^ std::hash<float>()(p[i]);
    return h;
  }
};

/// Per vertex: the first one at its position.
std::vector<uint32_t> weld(const Mesh& mesh) {
  std::unordered_map<vec3, uint32_t, PositionHash> at;
  std::vector<uint32_t> first;
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) {
    first.push_back(at.emplace(mesh.positions[i], i).first->second);
  }
  return first;
}

/// Per triangle: the number of the piece it belongs to. Vertices at one position are one.
std::vector<uint32_t> find_pieces(const Mesh& mesh, const std::vector<uint32_t>& welded,
                                  uint32_t& count) {
  Components components(mesh.positions.size());
  for (uint32_t i = 0; i < mesh.positions.size(); ++i) components.join(welded[i], i);
  for (const uvec3& t : mesh.triangles) {
    components.join(t.x, t.y);
    components.join(t.y, t.z);
  }
  std::unordered_map<uint32_t, uint32_t> number;
  std::vector<uint32_t> piece_of;
  for (const uvec3& t : mesh.triangles) {
    const auto next = static_cast<uint32_t>(number.size());
    piece_of.push_back(number.emplace(components.find(t.x), next).first->second);
  }
  count = static_cast<uint32_t>(number.size());
  return piece_of;
}

/// Per piece: area over diameter.
std::vector<double> piece_widths(const Mesh& mesh, const std::vector<uint32_t>& piece_of,
                                 uint32_t count) {
  std::vector<double> area(count, 0.0);
  std::vector<Bounds> bounds(count);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3 t = mesh.triangles[i];
    const dvec3 a(mesh.positions[t.x]);
    const dvec3 b(mesh.positions[t.y]);
    const dvec3 c(mesh.positions[t.z]);
    area[piece_of[i]] += 0.5 * glm::length(glm::cross(b - a, c - a));
    for (const dvec3& p : {a, b, c}) bounds[piece_of[i]].extend(vec3(p));
  }
  for (uint32_t i = 0; i < count; ++i) {
    const double diameter = 2 * static_cast<double>(bounds[i].radius());
    area[i] = diameter > 0 ? area[i] / diameter : 0;
  }
  return area;
}

/// Per piece: whether it is a sheet: the square of its border's length is above 8 times its area.
/// A disc has 4 pi, a longer leaf more; a tube, whose border are its ends, has at most 4 unless it
/// is wider than long, a closed piece 0.
std::vector<bool> find_sheets(const Mesh& mesh, const std::vector<uint32_t>& welded,
                              const std::vector<uint32_t>& piece_of, uint32_t count) {
  std::unordered_map<uint64_t, int> uses;
  const auto edge_of = [&](uvec3 t, int i) {
    const uint64_t a = welded[t[i]];
    const uint64_t b = welded[t[(i + 1) % 3]];
    return std::min(a, b) << 32 | std::max(a, b);
  };
  for (const uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++uses[edge_of(t, i)];
  }
  std::vector<double> border(count, 0.0);
  std::vector<double> area(count, 0.0);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3 t = mesh.triangles[i];
    const dvec3 corner[3] = {dvec3(mesh.positions[t.x]), dvec3(mesh.positions[t.y]),
                             dvec3(mesh.positions[t.z])};
    area[piece_of[i]] +=
        0.5 * glm::length(glm::cross(corner[1] - corner[0], corner[2] - corner[0]));
    for (int e = 0; e < 3; ++e) {
      if (uses[edge_of(t, e)] > 1) continue;
      border[piece_of[i]] += glm::distance(corner[e], corner[(e + 1) % 3]);
    }
  }
  std::vector<bool> sheets;
  for (uint32_t i = 0; i < count; ++i) sheets.push_back(border[i] * border[i] > 8 * area[i]);
  return sheets;
}

/// The part of a triangle that its material's mask leaves.
float mask_coverage(const Scene& scene, const Mesh& mesh, size_t triangle) {
  const Material& material = scene.materials[mesh.materials[triangle]];
  if (material.alpha_texture < 0) return 1;
  const uvec3 t = mesh.triangles[triangle];
  int inside = 0;
  int count = 0;
  for (int i = 0; i < mask_rows; ++i) {
    for (int j = 0; i + j < mask_rows; ++j) {
      const float u = (static_cast<float>(i) + 1.0f / 3) / mask_rows;
      const float v = (static_cast<float>(j) + 1.0f / 3) / mask_rows;
      vec2 uv(0);
      if (!mesh.uvs.empty()) {
        uv = mesh.uvs[t.x] * (1 - u - v) + mesh.uvs[t.y] * u + mesh.uvs[t.z] * v;
      }
      const vec4 texel = lookup_texture(scene.textures[material.alpha_texture], uv);
      const float mask =
          material.alpha_from_luminance ? (texel.x + texel.y + texel.z) / 3.0f : texel.w;
      inside += mask < material.alpha_cutoff ? 0 : 1;
      ++count;
    }
  }
  return static_cast<float>(inside) / static_cast<float>(count);
}

void make_chunks(ThinShape& shape) {
  ThinChunk chunk;
  const auto finish = [&] {
    if (chunk.piece_count > 0) shape.chunks.push_back(chunk);
    chunk = ThinChunk();
  };
  for (uint32_t i = 0; i < shape.pieces.size(); ++i) {
    const ThinPiece& piece = shape.pieces[i];
    if (chunk.piece_count == 0) chunk.first_piece = i;
    ++chunk.piece_count;
    chunk.primitive_count += shape.is_strands ? piece.vertex_count - 1 : piece.triangle_count;
    for (uint32_t v = 0; v < piece.vertex_count; ++v) {
      const vec4 p = shape.vertices[piece.first_vertex + v];
      chunk.bounds.extend(vec3(p) - vec3(p.w));
      chunk.bounds.extend(vec3(p) + vec3(p.w));
    }
    if (chunk.primitive_count >= chunk_primitives) finish();
  }
  finish();
}

/// Strands that stand near each other become neighbours, so that chunks are small.
void sort_by_root(ThinShape& shape) {
  Bounds box;
  const auto root = [&](const ThinPiece& piece) {
    return vec3(shape.vertices[piece.first_vertex]);
  };
  for (const ThinPiece& piece : shape.pieces) box.extend(root(piece));
  std::ranges::stable_sort(shape.pieces, {},
                           [&](const ThinPiece& piece) { return morton_code(box, root(piece)); });
}

ThinShape make_strands(const Curves& curves) {
  ThinShape shape;
  shape.is_strands = true;
  shape.vertices = curves.points;
  for (size_t i = 0; i + 1 < curves.offsets.size(); ++i) {
    shape.pieces.push_back({curves.offsets[i], curves.offsets[i + 1] - curves.offsets[i], 0, 0});
  }
  sort_by_root(shape);
  make_chunks(shape);
  return shape;
}

/// The triangles of a mesh, in order, that `keep` says.
Mesh cut_mesh(const Mesh& mesh, const std::vector<bool>& keep) {
  Mesh part;
  part.positions = mesh.positions;
  part.uvs = mesh.uvs;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!keep[i]) continue;
    part.triangles.push_back(mesh.triangles[i]);
    part.materials.push_back(mesh.materials[i]);
  }
  return part;
}

/// Thin pieces of a mesh, and all without a mask if `draws_solids`; `is_solid` marks the other
/// triangles.
ThinShape make_leaves(const Scene& scene, const Mesh& mesh, double max_width, bool draws_solids,
                      std::vector<bool>& is_solid) {
  ThinShape shape;
  uint32_t count = 0;
  const std::vector<uint32_t> welded = weld(mesh);
  const std::vector<uint32_t> piece_of = find_pieces(mesh, welded, count);
  const std::vector<double> widths = piece_widths(mesh, piece_of, count);
  std::vector<std::vector<uint32_t>> members(count);
  is_solid.assign(mesh.triangles.size(), false);
  bool has_masks = false;
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const bool has_mask = scene.materials[mesh.materials[i]].alpha_texture >= 0;
    is_solid[i] = !(widths[piece_of[i]] < max_width) && (!draws_solids || has_mask);
    if (is_solid[i]) continue;
    members[piece_of[i]].push_back(i);
    has_masks |= has_mask;
  }
  shape.piece_of.assign(mesh.triangles.size(), no_piece);
  const std::vector<bool> sheets = find_sheets(mesh, welded, piece_of, count);
  for (uint32_t p = 0; p < count; ++p) {
    const std::vector<uint32_t>& triangles = members[p];
    if (triangles.empty()) continue;
    ThinPiece piece{static_cast<uint32_t>(shape.vertices.size()), 0,
                    static_cast<uint32_t>(shape.triangles.size()), 0};
    std::unordered_map<uint32_t, uint32_t> index_of;
    for (const uint32_t triangle : triangles) {
      const float opacity = has_masks ? mask_coverage(scene, mesh, triangle) : 1.0f;
      if (!(opacity > 0)) continue;
      uvec3 corners;
      for (size_t c = 0; c < 3; ++c) {
        const uint32_t vertex = mesh.triangles[triangle][c];
        const auto next = static_cast<uint32_t>(shape.vertices.size());
        const auto [place, is_new] = index_of.emplace(vertex, next);
        if (is_new) shape.vertices.emplace_back(mesh.positions[vertex], 0.0f);
        corners[c] = place->second;
      }
      shape.piece_of[triangle] = static_cast<uint32_t>(shape.pieces.size());
      shape.triangles.push_back(corners);
      if (has_masks) shape.opacity.push_back(opacity);
    }
    piece.vertex_count = static_cast<uint32_t>(shape.vertices.size()) - piece.first_vertex;
    piece.triangle_count = static_cast<uint32_t>(shape.triangles.size()) - piece.first_triangle;
    piece.is_sheet = sheets[p];
    if (piece.triangle_count > 0) shape.pieces.push_back(piece);
  }
  make_chunks(shape);
  shape.levels = make_levels(shape);
  return shape;
}

/// Per prototype: the width in local units that is one pixel wide where its median instance stands.
std::vector<double> pixel_widths(const Scene& scene, int height_px) {
  const double pixel =
      2 * std::tan(0.5 * static_cast<double>(radians_from_degrees(scene.camera.fov_y_deg))) /
      height_px;
  std::vector<std::vector<double>> widths(scene.prototypes.size());
  std::vector<vec3> centers;
  for (const Prototype& prototype : scene.prototypes) {
    centers.push_back(local_bounds(prototype).center());
  }
  for (const Instance& instance : scene.instances) {
    const vec3 center = transform_point(instance.world_from_local, centers[instance.prototype]);
    const double distance = glm::distance(dvec3(center), dvec3(scene.camera.eye));
    const auto scale = static_cast<double>(uniform_scale(instance.world_from_local));
    if (scale > 0) widths[instance.prototype].push_back(distance * pixel / scale);
  }
  std::vector<double> medians;
  for (std::vector<double>& list : widths) {
    const auto middle = list.begin() + static_cast<std::ptrdiff_t>(list.size() / 2);
    std::nth_element(list.begin(), middle, list.end());
    medians.push_back(list.empty() ? 0 : *middle);
  }
  return medians;
}

bool uses_masks(const Scene& scene) {
  for (const Prototype& prototype : scene.prototypes) {
    for (const auto& shape : prototype.shapes) {
      const Mesh* mesh = std::get_if<Mesh>(&shape);
      if (mesh == nullptr) continue;
      for (const uint32_t material : mesh->materials) {
        if (scene.materials[material].alpha_texture >= 0) return true;
      }
    }
  }
  return false;
}

/// Triangles of all instances.
uint64_t count_triangles(const Scene& scene) {
  uint64_t count = 0;
  for (const Instance& instance : scene.instances) {
    for (const auto& shape : scene.prototypes[instance.prototype].shapes) {
      if (const Mesh* mesh = std::get_if<Mesh>(&shape)) count += mesh->triangles.size();
    }
  }
  return count;
}

ThinGeometry split_scene(const Scene& scene, int height_px, float max_width_px, bool draws_solids) {
  ThinGeometry geometry;
  const std::vector<double> pixel = pixel_widths(scene, height_px);
  geometry.solids.name = scene.name;
  geometry.solids.instancing = scene.instancing;
  geometry.solids.materials = scene.materials;
  geometry.solids.prototypes.resize(scene.prototypes.size());
  std::vector<std::vector<uint32_t>> shapes_of(scene.prototypes.size());
  geometry.shape_of.resize(scene.prototypes.size());
  for (size_t i = 0; i < scene.prototypes.size(); ++i) {
    for (const auto& shape : scene.prototypes[i].shapes) {
      ThinShape thin;
      if (const Mesh* mesh = std::get_if<Mesh>(&shape)) {
        std::vector<bool> is_solid;
        thin = make_leaves(scene, *mesh, pixel[i] * max_width_px, draws_solids, is_solid);
        if (std::find(is_solid.begin(), is_solid.end(), true) != is_solid.end()) {
          geometry.solids.prototypes[i].shapes.emplace_back(cut_mesh(*mesh, is_solid));
        }
      } else {
        thin = make_strands(std::get<Curves>(shape));
      }
      geometry.shape_of[i].push_back(
          thin.pieces.empty() ? no_piece : static_cast<uint32_t>(shapes_of[i].size()));
      if (thin.pieces.empty()) continue;
      shapes_of[i].push_back(static_cast<uint32_t>(geometry.shapes.size()));
      geometry.shapes.push_back(std::move(thin));
    }
  }
  uint32_t first_piece = 0;
  for (const Instance& instance : scene.instances) {
    geometry.first_instance.push_back(static_cast<uint32_t>(geometry.instances.size()));
    for (const uint32_t shape : shapes_of[instance.prototype]) {
      geometry.instances.push_back({shape, first_piece, instance.world_from_local});
      first_piece += static_cast<uint32_t>(geometry.shapes[shape].pieces.size());
    }
    if (!geometry.solids.prototypes[instance.prototype].shapes.empty()) {
      geometry.solids.instances.push_back(instance);
    }
  }
  if (uses_masks(geometry.solids)) geometry.solids.textures = scene.textures;
  return geometry;
}

}  // namespace

ThinGeometry make_thin_geometry(const Scene& scene, int height_px, float max_width_px,
                                uint64_t drawn_triangles) {
  ThinGeometry geometry = split_scene(scene, height_px, max_width_px, false);
  const uint64_t solids = count_triangles(geometry.solids);
  if (solids == 0 || solids > drawn_triangles) return geometry;
  return split_scene(scene, height_px, max_width_px, true);
}

uint64_t ThinGeometry::memory_bytes() const {
  uint64_t bytes = bytes_of(shapes, instances);
  for (const ThinShape& shape : shapes) {
    bytes += bytes_of(shape.vertices, shape.triangles, shape.opacity, shape.pieces, shape.chunks,
                      shape.levels, shape.piece_of);
    for (const ThinLevel& level : shape.levels) {
      bytes += bytes_of(level.error, level.vertices, level.triangles, level.opacity, level.pieces);
    }
  }
  return bytes;
}

uint32_t ThinGeometry::piece_at(const Scene& scene, const SurfacePoint& point) const {
  const uint32_t thin = shape_of[scene.instances[point.instance].prototype][point.shape];
  if (thin == no_piece) return no_piece;
  const ThinInstance& instance = instances[first_instance[point.instance] + thin];
  const ThinShape& shape = shapes[instance.shape];
  if (shape.piece_of.empty()) return no_piece;
  const uint32_t piece = shape.piece_of[point.primitive];
  return piece == no_piece ? no_piece : instance.first_piece + piece;
}

}  // namespace relume

#include <fmt/format.h>

#include <unordered_map>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/scene/io/obj_parts.h"
#include "core/scene/io/smooth_normals.h"
#include "core/scene/io/triangulate.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

RareEvent dropped_triangles("OBJ triangles without area dropped");
RareEvent hidden_faces("OBJ faces of see-through materials left out");
RareEvent replaced_normals("OBJ normals of zero length replaced");

/// A triangle as three corner numbers of ObjContent::corners.
struct CutTriangle {
  std::array<uint64_t, 3> corners;
  uint32_t material;
};

/// What makes two corners the same vertex.
struct VertexKey {
  int32_t position;
  int32_t uv;
  uint32_t normal;
  bool operator==(const VertexKey&) const = default;
};

struct VertexKeyHash {
  size_t operator()(const VertexKey& key) const {
    uint64_t h =
        uint64_t{static_cast<uint32_t>(key.position)} << 32 | static_cast<uint32_t>(key.uv);
    h = (h ^ (uint64_t{key.normal} * 0x9E3779B97F4A7C15u)) * 0xBF58476D1CE4E5B9u;
    return h ^ (h >> 31);
  }
};

class MeshBuilder {
 public:
  MeshBuilder(const ObjContent& content, const std::vector<uint32_t>& materials,
              const std::string& file)
      : content_(content), materials_(materials), file_(file) {}

  Mesh build(float smooth_angle_deg) {
    cut_faces();
    if (triangles_.empty()) {
      throw input_error(file_, "holds no visible triangle", "check its faces and the d of its MTL");
    }
    choose_normals(smooth_angle_deg);
    join_vertices();
    return std::move(mesh_);
  }

 private:
  vec3 position(uint64_t corner) const {
    return content_.positions[content_.corners[corner].position];
  }

  void cut_faces() {
    std::vector<vec3> polygon;
    std::vector<std::array<uint32_t, 3>> cuts;
    for (size_t face = 0; face < content_.face_materials.size(); ++face) {
      const uint32_t material = materials_[content_.face_materials[face]];
      if (material == hidden_material) {
        hidden_faces.add();
        continue;
      }
      const uint64_t first = content_.face_offsets[face];
      const uint64_t end = content_.face_offsets[face + 1];
      polygon.clear();
      for (uint64_t corner = first; corner < end; ++corner) polygon.push_back(position(corner));
      cuts.clear();
      if (!triangulate(polygon, cuts)) {
        throw limit_error(
            file_, fmt::format("face {} is concave with {} corners", face + 1, end - first),
            fmt::format("the limit is {}: cut it into triangles", max_concave_corners));
      }
      for (const auto& cut : cuts) {
        add_triangle({{first + cut[0], first + cut[1], first + cut[2]}, material});
      }
    }
  }

  void add_triangle(const CutTriangle& triangle) {
    const auto& [a, b, c] = triangle.corners;
    if (!has_area(position(a), position(b), position(c))) {
      dropped_triangles.add();
      return;
    }
    if (triangles_.size() >= max_triangles) {
      throw limit_error(file_, "too many triangles", fmt::format("the limit is {}", max_triangles));
    }
    triangles_.push_back(triangle);
  }

  bool has_file_normal(uint64_t corner) const {
    const int32_t index = content_.corners[corner].normal;
    return index >= 0 && file_normals_[index] != vec3(0);
  }

  /// Every corner gets a number: the file's normals first, computed ones behind them.
  void choose_normals(float smooth_angle_deg) {
    file_normals_.reserve(content_.normals.size());
    for (const vec3 normal : content_.normals) {
      file_normals_.push_back(normalize_or(normal, vec3(0)));
      if (file_normals_.back() == vec3(0)) replaced_normals.add();
    }
    bool complete = true;
    for (const CutTriangle& triangle : triangles_) {
      for (const uint64_t corner : triangle.corners) complete = complete && has_file_normal(corner);
    }
    if (complete) return;
    std::vector<uvec3> corners;
    corners.reserve(triangles_.size());
    for (const CutTriangle& t : triangles_) {
      corners.emplace_back(content_.corners[t.corners[0]].position,
                           content_.corners[t.corners[1]].position,
                           content_.corners[t.corners[2]].position);
    }
    smooth_ = make_smooth_normals(content_.positions, corners, smooth_angle_deg);
  }

  void join_vertices() {
    std::unordered_map<VertexKey, uint32_t, VertexKeyHash> vertices;
    vertices.reserve(content_.positions.size());
    const auto file_normals = static_cast<uint32_t>(file_normals_.size());
    mesh_.triangles.reserve(triangles_.size());
    mesh_.materials.reserve(triangles_.size());
    for (size_t t = 0; t < triangles_.size(); ++t) {
      uvec3 indices;
      for (size_t c = 0; c < 3; ++c) {
        const uint64_t corner = triangles_[t].corners[c];
        const ObjCorner& source = content_.corners[corner];
        const uint32_t normal = has_file_normal(corner)
                                    ? static_cast<uint32_t>(source.normal)
                                    : file_normals + smooth_.normal_of_corner[3 * t + c];
        const VertexKey key{source.position, source.uv, normal};
        const auto next = static_cast<uint32_t>(mesh_.positions.size());
        const auto [found, added] = vertices.try_emplace(key, next);
        if (added) add_vertex(key);
        indices[c] = found->second;
      }
      mesh_.triangles.push_back(indices);
      mesh_.materials.push_back(triangles_[t].material);
    }
  }

  void add_vertex(const VertexKey& key) {
    const size_t file_normals = file_normals_.size();
    mesh_.positions.push_back(content_.positions[key.position]);
    mesh_.normals.push_back(key.normal < file_normals ? file_normals_[key.normal]
                                                      : smooth_.normals[key.normal - file_normals]);
    if (content_.uvs.empty()) return;
    mesh_.uvs.push_back(key.uv >= 0 ? content_.uvs[key.uv] : vec2(0));
  }

  const ObjContent& content_;
  const std::vector<uint32_t>& materials_;
  const std::string& file_;
  std::vector<CutTriangle> triangles_;
  std::vector<vec3> file_normals_;  ///< unit, or zero where the file's is
  SmoothNormals smooth_;
  Mesh mesh_;
};

}  // namespace

Mesh build_obj_mesh(const ObjContent& content, const std::vector<uint32_t>& materials,
                    float smooth_angle_deg, const std::string& file) {
  return MeshBuilder(content, materials, file).build(smooth_angle_deg);
}

}  // namespace relume

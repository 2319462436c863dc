#include "core/scene/io/pbrt_shapes.h"

#include <fmt/format.h>

#include "core/scene/io/ply_file.h"
#include "core/scene/limits.h"
#include "core/scene/procedural/generators.h"

namespace relume {
namespace {

constexpr double max_bend_rad = 0.2;
constexpr int max_pieces = 16;
constexpr int disk_corners = 64;

/// Vectors of a parameter, each checked; "point P" and "point3 P" are the same.
std::vector<vec3> read_vectors(const PbrtParameters& parameters, std::string_view name) {
  const auto numbers = parameters.numbers(name, 3);
  std::vector<vec3> vectors;
  vectors.reserve(numbers.size() / 3);
  for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
    vectors.emplace_back(numbers[i], numbers[i + 1], numbers[i + 2]);
    if (is_coordinate(vectors.back())) continue;
    parameters.fail(fmt::format("\"{}\" {} is above 1e9", name, i / 3), "give a smaller number");
  }
  return vectors;
}

std::vector<uint32_t> read_indices(const PbrtParameters& parameters, size_t vertices) {
  std::vector<uint32_t> indices;
  for (const double index : parameters.numbers("indices", 1)) {
    if (!(index >= 0 && index < static_cast<double>(vertices))) {
      parameters.fail(fmt::format("index {} is {} of {} vertices", indices.size(), index, vertices),
                      "mend the indices");
    }
    indices.push_back(static_cast<uint32_t>(index));
  }
  return indices;
}

IndexedMesh read_triangles(const PbrtParameters& parameters, uint32_t corners) {
  IndexedMesh mesh;
  mesh.positions = read_vectors(parameters, "P");
  if (mesh.positions.empty()) parameters.fail("has no points P", "give it some");
  mesh.normals = read_vectors(parameters, "N");
  const std::string_view uv_name = parameters.has("uv") ? "uv" : "st";
  const auto uvs = parameters.numbers(uv_name, 2);
  for (size_t i = 0; i + 1 < uvs.size(); i += 2) mesh.uvs.emplace_back(uvs[i], uvs[i + 1]);
  const size_t vertices = mesh.positions.size();
  if ((!mesh.normals.empty() && mesh.normals.size() != vertices) ||
      (!mesh.uvs.empty() && mesh.uvs.size() != vertices)) {
    parameters.fail("has not as many normals or uvs as points", "give one a point or none");
  }
  std::vector<uint32_t> indices = read_indices(parameters, vertices);
  if (indices.empty() && vertices == corners) {
    for (uint32_t i = 0; i < corners; ++i) indices.push_back(i);
  }
  if (indices.empty() || indices.size() % corners != 0) {
    parameters.fail(fmt::format("{} indices make no faces of {}", indices.size(), corners),
                    "mend the indices");
  }
  for (size_t i = 0; i + corners <= indices.size(); i += corners) {
    mesh.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
    if (corners == 4) mesh.triangles.emplace_back(indices[i + 1], indices[i + 3], indices[i + 2]);
  }
  return mesh;
}

IndexedMesh read_sphere(const PbrtParameters& parameters) {
  SphereParams sphere;
  sphere.radius = static_cast<float>(parameters.number("radius", 1));
  if (!(sphere.radius > 0 && sphere.radius <= max_coordinate)) {
    parameters.fail("its radius is not above 0", "give a larger one");
  }
  sphere.rings = 64;
  Mesh mesh = make_sphere(sphere);
  return {std::move(mesh.positions), std::move(mesh.normals), std::move(mesh.uvs),
          std::move(mesh.triangles)};
}

IndexedMesh read_disk(const PbrtParameters& parameters) {
  const auto radius = static_cast<float>(parameters.number("radius", 1));
  const auto height = static_cast<float>(parameters.number("height", 0));
  if (!(radius > 0 && is_coordinate({radius, height, 0}))) {
    parameters.fail("its radius is not above 0", "give a larger one");
  }
  IndexedMesh mesh;
  for (uint32_t i = 0; i < disk_corners; ++i) {
    const float phi = 2 * pi * static_cast<float>(i) / disk_corners;
    mesh.positions.emplace_back(radius * std::cos(phi), radius * std::sin(phi), height);
    if (i >= 2) mesh.triangles.emplace_back(0, i - 1, i);
  }
  return mesh;
}

IndexedMesh read_plymesh(const PbrtParameters& parameters, const std::filesystem::path& folder) {
  const std::string name = parameters.text("filename", "");
  if (name.empty()) parameters.fail("plymesh lacks its filename", "give one");
  return read_ply(pbrt_file(folder, name, parameters.place));
}

/// The control points of span `i` in Bezier form.
std::vector<dvec3> bezier_span(const std::vector<vec3>& p, size_t i, size_t degree,
                               bool is_bspline) {
  if (!is_bspline) {
    return {p.begin() + static_cast<ptrdiff_t>(i * degree),
            p.begin() + static_cast<ptrdiff_t>(i * degree + degree + 1)};
  }
  const dvec3 a(p[i]);
  const dvec3 b(p[i + 1]);
  const dvec3 c(p[i + 2]);
  if (degree == 2) return {0.5 * (a + b), b, 0.5 * (b + c)};
  const dvec3 d(p[i + 3]);
  return {(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0,
          (b + 4.0 * c + d) / 6.0};
}

/// de Casteljau.
dvec3 eval_bezier(std::vector<dvec3> p, double t) {
  for (size_t count = p.size() - 1; count > 0; --count) {
    for (size_t i = 0; i < count; ++i) p[i] += (p[i + 1] - p[i]) * t;
  }
  return p[0];
}

/// By how much the control polygon turns, which is no less than what the curve does.
int piece_count(const std::vector<dvec3>& p) {
  double bend = 0;
  for (size_t i = 0; i + 2 < p.size(); ++i) {
    const dvec3 a = p[i + 1] - p[i];
    const dvec3 b = p[i + 2] - p[i + 1];
    bend += std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  }
  return std::clamp(static_cast<int>(std::ceil(bend / max_bend_rad)), 1, max_pieces);
}

}  // namespace

std::optional<IndexedMesh> read_pbrt_mesh(const PbrtStatement& shape,
                                          const std::filesystem::path& folder) {
  const std::string& kind = shape.words[0];
  const PbrtParameters& parameters = shape.parameters;
  if (kind == "trianglemesh" || kind == "loopsubdiv") return read_triangles(parameters, 3);
  if (kind == "bilinearmesh") return read_triangles(parameters, 4);
  if (kind == "plymesh") return read_plymesh(parameters, folder);
  if (kind == "sphere") return read_sphere(parameters);
  if (kind == "disk") return read_disk(parameters);
  return {};
}

std::vector<vec4> read_pbrt_curve(const PbrtStatement& shape) {
  const PbrtParameters& parameters = shape.parameters;
  const std::vector<vec3> control = read_vectors(parameters, "P");
  const std::string basis = parameters.text("basis", "bezier");
  const int64_t degree = parameters.integer("degree", 3);
  const bool is_bspline = basis == "bspline";
  if ((!is_bspline && basis != "bezier") || degree < 2 || degree > 3) {
    parameters.fail(fmt::format("curves of basis \"{}\" and degree {} are unknown", basis, degree),
                    "give bezier or bspline of degree 2 or 3");
  }
  const auto order = static_cast<size_t>(degree);
  const size_t n = control.size();
  if (n < order + 1 || (!is_bspline && (n - 1) % order != 0)) {
    parameters.fail(fmt::format("{} control points make no curve of degree {}", n, degree),
                    "mend the points");
  }
  const double width = parameters.number("width", 1);
  const double width0 = parameters.number("width0", width);
  const double width1 = parameters.number("width1", width);
  if (!(width0 >= 0 && width1 >= 0)) parameters.fail("its width is below 0", "give a larger one");
  const size_t spans = is_bspline ? n - order : (n - 1) / order;
  std::vector<vec4> points;
  for (size_t i = 0; i < spans; ++i) {
    const std::vector<dvec3> span = bezier_span(control, i, order, is_bspline);
    const int pieces = piece_count(span);
    for (int piece = i == 0 ? 0 : 1; piece <= pieces; ++piece) {
      const double t = static_cast<double>(piece) / pieces;
      const double along = (static_cast<double>(i) + t) / static_cast<double>(spans);
      points.emplace_back(vec3(eval_bezier(span, t)), 0.5 * (width0 + (width1 - width0) * along));
    }
  }
  return points;
}

}  // namespace relume

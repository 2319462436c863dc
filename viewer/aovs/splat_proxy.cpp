#include "viewer/aovs/splat_proxy.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/file.h"

namespace relume {
namespace {

constexpr uint64_t max_splats = uint64_t{16} << 20;

/// Corners of squares, four each, and what glTF wants to know of them.
struct Splats {
  std::vector<vec3> corners;
  Bounds bounds;
};

/// Corners are where the view's rays meet the plane of the sample, at most two sides of the square
/// nearer or further than it, so that surfaces seen from the side are filled without spikes.
Splats make_splats(const AovSamples& samples) {
  const CameraRays rays(samples.camera(), samples.width(), samples.height());
  Splats splats;
  samples.visit_hits([&](const AovHit& hit) {
    const float distance = glm::distance(hit.position, rays.eye());
    const float reach = 2 * hit.side_px * rays.footprint_per_depth() * distance;
    for (const vec2 corner : {vec2(-1, -1), vec2(1, -1), vec2(1, 1), vec2(-1, 1)}) {
      const vec3 direction = rays.direction(hit.film_px + 0.5f * hit.side_px * corner);
      const float slope = glm::dot(direction, hit.normal);
      const float along = glm::dot(hit.position - rays.eye(), hit.normal) / slope;
      const float met = std::abs(slope) > 1e-3f ? along : distance;
      const vec3 p = rays.eye() + direction * std::clamp(met, distance - reach, distance + reach);
      splats.corners.push_back(p);
      splats.bounds.extend(p);
    }
  });
  return splats;
}

/// Binary glTF 2.0: one mesh of triangles.
void write_glb(const std::filesystem::path& path, const Splats& splats) {
  const size_t squares = splats.corners.size() / 4;
  std::vector<uint32_t> indices;
  indices.reserve(6 * squares);
  for (uint32_t first = 0; first < splats.corners.size(); first += 4) {
    for (const uint32_t corner : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + corner);
  }
  const size_t position_bytes = splats.corners.size() * sizeof(vec3);
  const size_t index_bytes = indices.size() * sizeof(uint32_t);
  const Bounds& b = splats.bounds;
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],)"
      R"("buffers":[{{"byteLength":{}}}],"bufferViews":[{{"buffer":0,"byteLength":{}}},)"
      R"({{"buffer":0,"byteOffset":{},"byteLength":{}}}],"accessors":[{{"bufferView":0,)"
      R"("componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},)"
      R"({{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}})",
      position_bytes + index_bytes, position_bytes, position_bytes, index_bytes,
      splats.corners.size(), b.low.x, b.low.y, b.low.z, b.high.x, b.high.y, b.high.z,
      indices.size());
  json.resize((json.size() + 3) / 4 * 4, ' ');
  constexpr uint32_t gltf_magic = 0x46546c67;
  constexpr uint32_t json_type = 0x4e4f534a;
  constexpr uint32_t binary_type = 0x004e4942;
  const auto json_bytes = static_cast<uint32_t>(json.size());
  const auto binary_bytes = static_cast<uint32_t>(position_bytes + index_bytes);
  const std::array<uint32_t, 5> head = {gltf_magic, 2, 28 + json_bytes + binary_bytes, json_bytes,
                                        json_type};
  const std::array<uint32_t, 2> binary_head = {binary_bytes, binary_type};
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(head)));
  file.append(std::as_bytes(std::span(json)));
  file.append(std::as_bytes(std::span(binary_head)));
  file.append(std::as_bytes(std::span(splats.corners)));
  file.append(std::as_bytes(std::span(indices)));
  file.commit();
}

std::string format_vector(vec3 v) {
  return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

/// As a JSON string.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string format_scene(const AovSamples& samples, const std::string& geometry) {
  const Camera& camera = samples.camera();
  return fmt::format(R"({{
  "name": "samples",
  "image": {{"width": {}, "height": {}}},
  "camera": {{"eye": {}, "target": {}, "up": {}, "fov_y_deg": {}}},
  "geometry": [{{"file": {}}}],
  "lights": [
    {{"name": "key", "position": {{"relative": [2, 2.5, 1.5]}}, "gain_relative": 40}},
    {{"name": "fill", "position": {{"relative": [-2.5, 1, 2.5]}}, "gain_relative": 10}},
    {{"name": "rim", "position": {{"relative": [-2.5, 1.5, -2]}}, "gain_relative": 20}}
  ]
}}
)",
                     samples.width(), samples.height(), format_vector(camera.eye),
                     format_vector(camera.target), format_vector(camera.up), camera.fov_y_deg,
                     quoted(geometry));
}

}  // namespace

std::filesystem::path write_splat_proxy(const AovSamples& samples,
                                        const std::filesystem::path& output) {
  if (samples.sample_count() > max_splats) {
    throw limit_error(
        output.string(),
        fmt::format("{} samples are too many to cast shadows", samples.sample_count()),
        "give --proxy");
  }
  std::filesystem::path scene = output;
  scene.replace_extension(".proxy.json");
  std::filesystem::path mesh = output;
  mesh.replace_extension(".proxy.glb");
  write_glb(mesh, make_splats(samples));
  write_file_atomic(scene, format_scene(samples, mesh.filename().string()));
  return scene;
}

}  // namespace relume

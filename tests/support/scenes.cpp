#include "tests/support/scenes.h"

#include <algorithm>

#include "core/base/check.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"

namespace relume::test {

Camera make_camera(vec3 eye, vec3 target, float fov_y_deg, vec3 up) {
  return {.eye = eye, .target = target, .up = up, .fov_y_deg = fov_y_deg};
}

Scene make_empty_scene(const Camera& camera, int width, int height) {
  Scene scene;
  scene.name = "test";
  scene.width = width;
  scene.height = height;
  scene.camera = camera;
  const auto table = shader_table();
  scene.shaders.assign(table.begin(), table.end());
  return scene;
}

uint32_t add_material(Scene& scene, std::string_view shader,
                      const std::vector<std::pair<std::string_view, vec3>>& values) {
  Material material;
  material.name = std::string(shader);
  const auto found = std::find_if(scene.shaders.begin(), scene.shaders.end(),
                                  [&](const ShaderInfo* info) { return info->name == shader; });
  CHECK_MSG(found != scene.shaders.end(), "shader {}", shader);
  material.shader = static_cast<int>(found - scene.shaders.begin());
  for (const auto& [name, value] : values) {
    material.parameters.push_back({std::string(name), value, -1});
  }
  scene.materials.push_back(material);
  return static_cast<uint32_t>(scene.materials.size() - 1);
}

void add_shape(Scene& scene, std::variant<Mesh, Curves> shape, const mat4x3& world_from_local) {
  scene.instances.push_back({static_cast<uint32_t>(scene.prototypes.size()), world_from_local});
  Prototype prototype;
  prototype.name = "shape " + std::to_string(scene.prototypes.size());
  prototype.shapes.push_back(std::move(shape));
  scene.prototypes.push_back(std::move(prototype));
}

Mesh make_quad(vec3 center, vec3 half_u, vec3 half_v, uint32_t material) {
  Mesh mesh;
  mesh.positions = {center - half_u - half_v, center + half_u - half_v, center + half_u + half_v,
                    center - half_u + half_v};
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {material, material};
  return mesh;
}

Mesh make_sphere(vec3 center, float radius, int rings, uint32_t material) {
  Mesh mesh;
  const int sectors = 2 * rings;
  for (int ring = 0; ring <= rings; ++ring) {
    const double theta = 3.14159265358979323846 * ring / rings;
    for (int sector = 0; sector < sectors; ++sector) {
      const double phi = 3.14159265358979323846 * sector / rings;
      const bool pole = ring == 0 || ring == rings;
      const dvec3 n(pole ? 0 : std::sin(theta) * std::cos(phi), std::cos(theta),
                    pole ? 0 : std::sin(theta) * std::sin(phi));
      mesh.normals.push_back(vec3(n));
      mesh.positions.push_back(center + radius * vec3(n));
    }
  }
  const auto vertex = [&](int ring, int sector) {
    return static_cast<uint32_t>(ring * sectors + sector % sectors);
  };
  for (int ring = 0; ring < rings; ++ring) {
    for (int sector = 0; sector < sectors; ++sector) {
      const uint32_t a = vertex(ring, sector);
      const uint32_t b = vertex(ring, sector + 1);
      const uint32_t c = vertex(ring + 1, sector);
      const uint32_t d = vertex(ring + 1, sector + 1);
      if (ring > 0) mesh.triangles.push_back({a, b, c});
      if (ring < rings - 1) mesh.triangles.push_back({b, d, c});
    }
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

Curves make_strand(vec3 root, vec3 tip, float radius, int segments, uint32_t material) {
  Curves curves;
  for (int i = 0; i <= segments; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(segments);
    curves.points.emplace_back(glm::mix(root, tip, t), radius);
  }
  curves.offsets = {0, static_cast<uint32_t>(segments + 1)};
  curves.materials = {material};
  return curves;
}

Scene make_plane_scene(float half_size, vec3 albedo, int width, int height) {
  Scene scene = make_empty_scene(make_camera({0, 0, 4}, {0, 0, 0}, 40), width, height);
  const uint32_t material = add_material(scene, "lambert", {{"diffuse", albedo}});
  add_shape(scene, make_quad(vec3(0), {half_size, 0, 0}, {0, half_size, 0}, material));
  return scene;
}

Light make_point_light(vec3 position, float gain, bool falloff) {
  Light light;
  light.type = LightType::point;
  light.position = position;
  light.gain = gain;
  light.falloff = falloff;
  return light;
}

Light make_spot_light(vec3 position, vec3 direction, float inner_deg, float outer_deg,
                      bool falloff) {
  Light light = make_point_light(position, 1, falloff);
  light.type = LightType::spot;
  light.direction = direction;
  light.inner_angle_deg = inner_deg;
  light.outer_angle_deg = outer_deg;
  return light;
}

Light make_directional_light(vec3 direction, float gain) {
  Light light;
  light.type = LightType::directional;
  light.direction = direction;
  light.gain = gain;
  return light;
}

mat4x3 make_similarity(float scale, vec3 offset) {
  return {vec3(scale, 0, 0), vec3(0, scale, 0), vec3(0, 0, scale), offset};
}

Scene move_scene(const Scene& scene, float scale, vec3 offset) {
  Scene moved = scene;
  const mat4x3 world_from_old = make_similarity(scale, offset);
  moved.camera.eye = transform_point(world_from_old, scene.camera.eye);
  moved.camera.target = transform_point(world_from_old, scene.camera.target);
  for (Instance& instance : moved.instances) {
    instance.world_from_local = compose(world_from_old, instance.world_from_local);
  }
  for (Light& light : moved.lights) {
    light.position = transform_point(world_from_old, light.position);
    if (light.falloff && light.type != LightType::directional) light.gain *= scale * scale;
  }
  return moved;
}

CacheInfo make_cache_info(const Scene& scene, const SampleTypes& types, int spp, uint64_t seed) {
  CacheInfo info;
  info.width = scene.width;
  info.height = scene.height;
  info.camera = scene.camera;
  info.types = types.types;
  info.bounds = world_bounds(scene);
  info.method = "all";
  info.spp = spp;
  info.seed = seed;
  info.scene_name = scene.name;
  info.lights = scene.lights;
  return info;
}

RelightCache make_full_cache(const Scene& scene, const Tracer& tracer, int spp, uint64_t seed) {
  const ViewSampler view = make_view_sampler(scene, tracer, scene.width, scene.height, spp, seed);
  CacheWriter writer;
  CacheInfo info = make_cache_info(scene, view.types, spp, seed);
  for (int i = 0; i < tile_count(view); ++i) {
    const SampleTile tile = sample_tile(view, i);
    info.sample_count += tile.row_count();
    writer.add(pack_tile(tile, view.types.types));
  }
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "test");
}

Image render_frame(const RelightCache& cache, std::span<const Light> lights,
                   VisibilitySource* shadows) {
  RelightState state = make_relight_state(cache);
  relight(state, lights, shadows);
  return state.frame;
}

float max_difference(const Image& a, const Image& b) {
  CHECK_MSG(a.pixels.size() == b.pixels.size(), "{} {}", a.pixels.size(), b.pixels.size());
  float largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const float difference = std::abs(a.pixels[i] - b.pixels[i]);
    if (!(difference <= largest)) largest = difference;
  }
  return largest;
}

}  // namespace relume::test

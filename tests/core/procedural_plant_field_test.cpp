#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <set>

#include "core/base/parallel.h"
#include "core/scene/procedural/generators.h"
#include "core/scene/procedural/mesh_builder.h"
#include "core/scene/procedural/plant_species.h"
#include "core/scene/procedural/terrain.h"
#include "core/scene/scene.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

Scene scene_with_materials(size_t count) {
  Scene scene;
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  scene.materials.resize(count);
  return scene;
}

PlantFieldParams full_params() {
  PlantFieldParams params;
  params.leaf_materials = {0, 1, 2};
  params.grass_materials = {3, 4};
  params.flower_materials = {5, 6};
  params.stem_material = 7;
  params.ground_material = 8;
  return params;
}

const Mesh& mesh_of(const Prototype& prototype) {
  return std::get<Mesh>(prototype.shapes.at(0));
}

bool same_bytes(const Scene& a, const Scene& b) {
  if (a.prototypes.size() != b.prototypes.size() || a.instances.size() != b.instances.size()) {
    return false;
  }
  for (size_t i = 0; i < a.prototypes.size(); ++i) {
    const Mesh& x = mesh_of(a.prototypes[i]);
    const Mesh& y = mesh_of(b.prototypes[i]);
    if (x.positions != y.positions || x.normals != y.normals || x.triangles != y.triangles ||
        x.materials != y.materials) {
      return false;
    }
  }
  return std::equal(a.instances.begin(), a.instances.end(), b.instances.begin(),
                    [](const Instance& x, const Instance& y) {
                      return x.prototype == y.prototype && x.world_from_local == y.world_from_local;
                    });
}

TEST(PlantField, DefaultsStandForTenMillionTriangles) {
  Scene scene = scene_with_materials(9);
  add_plant_field(full_params(), scene);
  EXPECT_NO_THROW(validate_scene(scene));
  const SceneCounts counts = count_scene(scene);
  EXPECT_GE(counts.instanced_triangles, 10'000'000u);
  EXPECT_LE(counts.triangles, counts.instanced_triangles / 50);
  EXPECT_EQ(scene.instances.size(), 1u + 5000u + 20000u);
}

TEST(PlantSpecies, StandOnTheGroundAtTheirRoot) {
  const std::vector<std::pair<const char*, std::function<Mesh(Random&)>>> species = {
      {"tuft", [](Random& r) { return make_grass_tuft({}, {}, r); }},
      {"fern", [](Random& r) { return make_fern(1, {}, r); }},
      {"herb", [](Random& r) { return make_leafy_herb(0.5f, 0.1f, {}, r); }},
      {"daisy", [](Random& r) { return make_flower_group(FlowerKind::daisy, 0.4f, {}, r); }},
      {"cup", [](Random& r) { return make_flower_group(FlowerKind::cup, 0.4f, {}, r); }},
      {"spike", [](Random& r) { return make_flower_group(FlowerKind::spike, 0.4f, {}, r); }},
      {"tree", [](Random& r) {
         return make_woody_plant({3, 0.07f, 1, 3, 4, 6, 0.1f, 0.85f}, {}, r);
       }}};
  for (const auto& [name, make] : species) {
    for (uint64_t seed = 0; seed < 5; ++seed) {
      Random random(seed, RandomStream::tests, 0);
      const Mesh mesh = make(random);
      float low = 1;
      for (const vec3 p : mesh.positions) low = std::min(low, p.y);
      EXPECT_LE(low, 0.0f) << name << " floats";
      EXPECT_GE(low, -0.02f) << name;
    }
  }
}

TEST(PlantField, InstancesStandOnTheGroundWithinTheField) {
  Scene scene = scene_with_materials(9);
  const PlantFieldParams params = full_params();
  add_plant_field(params, scene);
  const Terrain terrain(params.size, params.hill_height, params.seed);
  for (size_t i = 1; i < scene.instances.size(); ++i) {
    const mat4x3& m = scene.instances[i].world_from_local;
    const vec3 root = m[3];
    ASSERT_LE(std::abs(root.x), 0.5f * params.size) << "instance " << i;
    ASSERT_LE(std::abs(root.z), 0.5f * params.size) << "instance " << i;
    const float above = root.y - terrain.height({root.x, root.z});
    ASSERT_LE(above, 0) << "instance " << i << " floats";
    ASSERT_GE(above, -0.1f) << "instance " << i << " is buried";
    const float scale = glm::length(m[1]);
    ASSERT_GT(scale, 0.2f);
    ASSERT_LT(scale, 1.5f);
    ASSERT_GT(m[1].y, 0.8f * scale) << "instance " << i << " lies down";
    ASSERT_NEAR(glm::length(m[0]), scale, 1e-4f);
    ASSERT_NEAR(glm::dot(m[0], m[1]), 0, 1e-5f);
    ASSERT_GT(glm::dot(m[0], glm::cross(m[1], m[2])), 0) << "instance " << i << " is mirrored";
  }
}

TEST(PlantField, EverySpeciesIsUsedAndVaries) {
  Scene scene = scene_with_materials(9);
  add_plant_field(full_params(), scene);
  std::vector<size_t> uses(scene.prototypes.size());
  std::set<float> scales;
  for (const Instance& instance : scene.instances) {
    ++uses.at(instance.prototype);
    scales.insert(glm::length(instance.world_from_local[1]));
  }
  for (size_t i = 0; i < uses.size(); ++i) EXPECT_GT(uses[i], 0u) << scene.prototypes[i].name;
  EXPECT_GT(scales.size(), 10000u);
  std::set<uint32_t> materials;
  for (const Prototype& prototype : scene.prototypes) {
    materials.insert(mesh_of(prototype).materials.begin(), mesh_of(prototype).materials.end());
  }
  EXPECT_EQ(materials.size(), 9u) << "every material is on some plant";
}

TEST(PlantField, PlantsHaveNaturalSizesAndStandOnTheirRoot) {
  Scene scene = scene_with_materials(9);
  add_plant_field(full_params(), scene);
  for (size_t i = 1; i < scene.prototypes.size(); ++i) {
    Bounds bounds;
    for (const vec3 p : mesh_of(scene.prototypes[i]).positions) bounds.extend(p);
    const std::string& name = scene.prototypes[i].name;
    EXPECT_LT(std::abs(bounds.low.y), 0.12f) << name;
    EXPECT_GT(bounds.high.y, 0.08f) << name;
    EXPECT_LT(bounds.high.y, name.starts_with("tree") ? 6.0f : 2.5f) << name;
  }
}

TEST(PlantField, FacesTurnTheWayOfTheirNormals) {
  Scene scene = scene_with_materials(9);
  add_plant_field(full_params(), scene);
  for (const Prototype& prototype : scene.prototypes) {
    const Mesh& mesh = mesh_of(prototype);
    size_t against = 0;
    for (const uvec3& t : mesh.triangles) {
      const vec3 a = mesh.positions[t.x];
      const vec3 face = glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a);
      const vec3 shading = mesh.normals[t.x] + mesh.normals[t.y] + mesh.normals[t.z];
      against += glm::dot(face, shading) <= 0;
    }
    EXPECT_EQ(against, 0u) << prototype.name << ", of " << mesh.triangles.size();
  }
}

TEST(PlantField, PathIsKeptFreeOfTallPlants) {
  Scene scene = scene_with_materials(9);
  const PlantFieldParams params = full_params();
  add_plant_field(params, scene);
  const Terrain terrain(params.size, params.hill_height, params.seed);
  size_t on_path = 0;
  size_t plants = 0;
  for (const Instance& instance : scene.instances) {
    const std::string& name = scene.prototypes[instance.prototype].name;
    if (name.starts_with("grass") || name == "ground") continue;
    ++plants;
    const vec3 root = instance.world_from_local[3];
    on_path += terrain.distance_from_path({root.x, root.z}) < 0.9f;
  }
  EXPECT_EQ(plants, params.plants);
  EXPECT_LT(on_path, plants / 100);
}

TEST(PlantField, DependsOnTheSeedButNotOnThreads) {
  PlantFieldParams params = full_params();
  params.plants = 700;
  params.grass = 1500;
  const auto make = [&](int threads) {
    set_thread_count(threads);
    Scene scene = scene_with_materials(9);
    add_plant_field(params, scene);
    set_thread_count(0);
    return scene;
  };
  const Scene one = make(1);
  EXPECT_TRUE(same_bytes(one, make(4)));
  params.seed = 99;
  EXPECT_FALSE(same_bytes(one, make(1)));
}

TEST(PlantField, KeepsTheSceneInvariantsAtTheExtremes) {
  for (const float size : {1e-6f, 0.5f, 1000.0f, 1e6f}) {
    for (const float hills : {0.0f, 100.0f}) {
      Scene scene = scene_with_materials(1);
      PlantFieldParams params;
      params.size = size;
      params.hill_height = hills;
      params.plants = 50;
      params.grass = 50;
      add_plant_field(params, scene);
      EXPECT_NO_THROW(validate_scene(scene)) << "size " << size << " hills " << hills;
    }
  }
  Scene scene = scene_with_materials(1);
  PlantFieldParams params;
  params.plants = 0;
  params.grass = 0;
  add_plant_field(params, scene);
  EXPECT_NO_THROW(validate_scene(scene)) << "ground only";
}

TEST(Terrain, StaysWithinItsHeightAndHasMatchingNormals) {
  const Terrain terrain(20, 0.5f, 3);
  for (int i = 0; i < 2000; ++i) {
    const vec2 place(0.0095f * static_cast<float>(i) - 9.5f, 9 - 0.009f * static_cast<float>(i));
    const float height = terrain.height(place);
    ASSERT_LE(std::abs(height), 0.5f);
    const vec3 n = terrain.normal(place);
    ASSERT_NEAR(glm::length(n), 1, 1e-6f);
    // Moving along the tangent plane changes the height as the normal says.
    const float step = 0.01f;
    const float expected = -n.x / n.y * step;
    ASSERT_NEAR(terrain.height(place + vec2(step, 0)) - height, expected, 2e-3f * step + 2e-4f);
  }
}

TEST(MeshBuilder, DropsTrianglesWithoutAreaAndUnusedVertices) {
  MeshBuilder builder(4);
  const vec3 up(0, 1, 0);
  const uint32_t a = builder.add_vertex({0, 0, 0}, up, {});
  const uint32_t unused = builder.add_vertex({9, 9, 9}, up, {});
  const uint32_t b = builder.add_vertex({1, 0, 0}, up, {});
  const uint32_t c = builder.add_vertex({2, 0, 0}, up, {});
  const uint32_t d = builder.add_vertex({0, 0, 1}, 5.0f * up, {});
  EXPECT_EQ(unused, 1u);
  builder.add_triangle(a, b, c);
  builder.add_triangle(a, a, d);
  builder.add_triangle(a, d, b);
  const Mesh mesh = builder.take();
  ASSERT_EQ(mesh.triangles.size(), 1u);
  EXPECT_EQ(mesh.triangles[0], uvec3(0, 2, 1));
  ASSERT_EQ(mesh.positions.size(), 3u);
  EXPECT_EQ(mesh.positions[2], vec3(0, 0, 1));
  EXPECT_EQ(mesh.normals[2], up) << "made unit length";
  EXPECT_EQ(mesh.materials, std::vector<uint32_t>{4});
}

TEST(TraceArc, KeepsLengthFrameAndTurn) {
  const float quarter = 0.5f * pi;
  const vec3 up(0, 1, 0);
  // side = cross(outward, up) with outward = x: the arc ends in the outward direction.
  const std::vector<Section> arc = trace_arc({1, 2, 3}, up, {0, 0, 1}, 2, quarter, 64);
  ASSERT_EQ(arc.size(), 65u);
  EXPECT_LT(glm::length(arc.back().tangent - vec3(1, 0, 0)), 1e-5f);
  EXPECT_LT(glm::length(arc.back().normal - up), 1e-5f) << "the upper face ends facing up";
  double length = 0;
  for (size_t i = 0; i < arc.size(); ++i) {
    EXPECT_NEAR(glm::dot(arc[i].tangent, arc[i].side), 0, 1e-6);
    EXPECT_NEAR(glm::dot(arc[i].tangent, arc[i].normal), 0, 1e-6);
    if (i > 0) length += glm::length(arc[i].center - arc[i - 1].center);
  }
  EXPECT_NEAR(length, 2, 1e-4);
}

}  // namespace
}  // namespace relume

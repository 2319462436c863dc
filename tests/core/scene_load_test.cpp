#include <gtest/gtest.h>

#include "core/scene/io/load_scene.h"
#include "core/scene/scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

const std::filesystem::path source_folder = RELUME_SOURCE_DIR;

Scene load(const std::string& name) {
  return load_scene(name, shader_table());
}

TEST(BuiltinScenes, LoadFromAnywhereAndEqualTheirFiles) {
  EXPECT_EQ(builtin_scene_names(), (std::vector<std::string>{"hair", "plants", "spheres"}));
  for (const std::string& name : builtin_scene_names()) {
    SCOPED_TRACE(name);
    const Scene scene = load(name);
    EXPECT_TRUE(scene.file.empty());
    EXPECT_EQ(scene.name, name);
    EXPECT_EQ(scene.text, test::read_all(source_folder / "scenes" / (name + ".json")));
    EXPECT_GE(scene.lights.size(), 2u);
  }
}

TEST(BuiltinScenes, HairIsThinnerThanAPixel) {
  const Scene scene = load("hair");
  const SceneCounts counts = count_scene(scene);
  EXPECT_GE(counts.strands, 60000u);
  const CameraRays rays(scene.camera, scene.width, scene.height);
  double widest_px = 0;
  for (const auto& shape : scene.prototypes.at(0).shapes) {
    const Curves* curves = std::get_if<Curves>(&shape);
    if (curves == nullptr) continue;
    for (const vec4 p : curves->points) {
      const float depth = rays.project(vec3(p)).depth;
      widest_px = std::max(widest_px, double{2 * p.w / (depth * rays.footprint_per_depth())});
    }
  }
  EXPECT_LT(widest_px, 0.4);
  EXPECT_GT(widest_px, 0.1);
}

TEST(BuiltinScenes, PlantsShowTenMillionTriangles) {
  const SceneCounts counts = count_scene(load("plants"));
  EXPECT_GE(counts.instanced_triangles, 10'000'000u);
  EXPECT_LT(counts.triangles, counts.instanced_triangles / 20);
}

TEST(BuiltinScenes, RepresentativeLightsStayOutsideTheHair) {
  const Scene scene = load("hair");
  const Bounds bounds = world_bounds(scene);
  for (uint64_t i = 0; i < 200; ++i) {
    const vec3 p =
        interpolate_light(scene.representative_low, scene.representative_high, 1, i).position;
    const bool inside =
        glm::all(glm::greaterThan(p, bounds.low)) && glm::all(glm::lessThan(p, bounds.high));
    EXPECT_FALSE(inside) << i;
  }
}

TEST(LoadScene, NamesThePathOfAMissingScene) {
  EXPECT_ERROR(load("no/such.json"), ErrorKind::input, "no/such.json");
  EXPECT_ERROR(load("no/such.json"), ErrorKind::input, "hair, plants, spheres");
  EXPECT_ERROR(load("/"), ErrorKind::input, "is not a regular file");
}

TEST(LoadScene, SaysThatGeometryAloneIsNoScene) {
  const test::TemporaryFolder folder;
  for (const char* name : {"a.obj", "a.ply", "a.hair"}) {
    test::write_all(folder.file(name), "v 0 0 0\n");
    EXPECT_ERROR(load(folder.file(name).string()), ErrorKind::input, "is geometry alone");
  }
}

TEST(LoadScene, SaysThatAnImageIsNoScene) {
  const test::TemporaryFolder folder;
  test::write_all(folder.file("a.png"), "\x89PNG");
  EXPECT_ERROR(load(folder.file("a.png").string()), ErrorKind::input, "is an image, no scene");
}

TEST(LoadScene, ResolvesPathsAgainstTheScenesFolder) {
  const test::TemporaryFolder folder;
  test::write_all(folder.file("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  test::write_all(folder.file("s.json"),
                  R"({"camera": {"fit": true}, "geometry": [{"file": "a.obj"}], "lights": []})");
  const Scene scene = load(folder.file("s.json").string());
  EXPECT_EQ(count_scene(scene).triangles, 1u);
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.file, folder.file("s.json"));
  // What a cache stores, text and file, is enough to load it again.
  EXPECT_EQ(count_scene(parse_scene(scene.text, scene.file, shader_table())).triangles, 1u);
}

TEST(LoadScene, StopsWhenTheCallbackSaysSo) {
  const ProgressCallback stop = [](const std::string&, double, double) { return false; };
  EXPECT_ERROR(load_scene("spheres", shader_table(), stop), ErrorKind::cancelled, "load");
}

struct RealScene {
  const char* name;
  uint64_t triangles;  ///< stored, the floor plane included
  uint64_t strands;
  uint64_t least_instanced;
};

class RealScenes : public testing::TestWithParam<RealScene> {};

TEST_P(RealScenes, LoadWithTheirKnownCounts) {
  if (!std::filesystem::exists(source_folder / "../shared/scenes")) {
    GTEST_SKIP() << "the folder ../shared/scenes is absent";
  }
  const RealScene& expected = GetParam();
  const auto file = source_folder / "scenes/real" / (std::string(expected.name) + ".json");
  const Scene scene = load(file.string());
  const SceneCounts counts = count_scene(scene);
  EXPECT_EQ(counts.triangles, expected.triangles);
  EXPECT_EQ(counts.strands, expected.strands);
  EXPECT_GE(counts.instanced_triangles, expected.least_instanced);
}

// Triangles as in the assets' own list, less those without area (64 of the flower box, 608 of the
// pool table), plus two of the floor.
INSTANTIATE_TEST_SUITE_P(All, RealScenes,
                         testing::Values(RealScene{"ponytail", 8320, 4933, 8320},
                                         RealScene{"fur", 760, 10027, 760},
                                         RealScene{"grove", 198'396 + 2, 0, 100'000'000},
                                         RealScene{"flower_box", 60'822 + 2, 0, 60'824},
                                         RealScene{"pool_table", 57'184 - 608 + 2, 0, 56'578},
                                         RealScene{"pine", 108'810 + 2, 0, 108'812},
                                         RealScene{"decorative_plant", 63'428 + 2, 0, 63'430}),
                         [](const auto& test) { return std::string(test.param.name); });

/// A scene of one triangle that validate_scene accepts.
Scene valid_scene() {
  Scene scene;
  scene.name = "hand-made";
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  scene.materials.emplace_back().name = "clay";
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  mesh.materials = {0};
  scene.prototypes.emplace_back().shapes.emplace_back(mesh);
  scene.instances.emplace_back();
  return scene;
}

TEST(ValidateScene, AcceptsAnEmptyLightListAndBareMeshes) {
  EXPECT_NO_THROW(validate_scene(valid_scene()));
}

TEST(ValidateScene, FindsEveryBrokenInvariant) {
  const auto expect = [](const std::string& part, const auto& damage) {
    Scene scene = valid_scene();
    damage(scene, std::get<Mesh>(scene.prototypes[0].shapes[0]));
    SCOPED_TRACE(part);
    EXPECT_ERROR(validate_scene(scene), ErrorKind::input, part);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  expect("vertex 1", [&](Scene&, Mesh& m) { m.positions[1].y = nan; });
  expect("refers to vertex 3 of 3", [](Scene&, Mesh& m) { m.triangles[0].z = 3; });
  expect("has no area", [](Scene&, Mesh& m) { m.positions[2] = {2, 0, 0}; });
  expect("refers to material 1", [](Scene&, Mesh& m) { m.materials[0] = 1; });
  expect("1 normals for 3", [](Scene&, Mesh& m) { m.normals = {{0, 0, 1}}; });
  expect("normal 0", [](Scene&, Mesh& m) { m.normals.assign(3, vec3(0, 0, 0.5f)); });
  expect("shader for strands", [](Scene& s, Mesh&) { s.materials[0].shader = 2; });
  expect("has no shader", [](Scene& s, Mesh&) { s.materials[0].shader = 9; });
  expect("1.5 is out of range", [](Scene& s, Mesh&) {
    s.materials[0].parameters.push_back({"diffuse", vec3(1.5f), -1});
  });
  expect("missing texture", [](Scene& s, Mesh&) {
    s.materials[0].parameters.push_back({"diffuse", vec3(1), 0});
  });
  expect("singular", [](Scene& s, Mesh&) { s.instances[0].world_from_local[1] = vec3(0); });
  for (const float bad : {nan, 1.1e9f, -std::numeric_limits<float>::infinity()}) {
    expect("its transform is not finite or above 1e9",
           [&](Scene& s, Mesh&) { s.instances[0].world_from_local[3].y = bad; });
  }
  expect("reaches beyond", [](Scene& s, Mesh&) {
    s.instances[0].world_from_local[3] = vec3(0.9999999e9f);
    s.instances[0].world_from_local[0] = vec3(1e6f, 0, 0);
  });
  expect("has no prototype", [](Scene& s, Mesh&) { s.instances[0].prototype = 1; });
  expect("nothing is placed", [](Scene& s, Mesh&) { s.instances.clear(); });
  expect("gain", [&](Scene& s, Mesh&) { s.lights.emplace_back().gain = nan; });
}

TEST(ValidateScene, ChecksStrands) {
  Curves curves;
  curves.points = {{0, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 0, 1}, {0, 1, 0, 1}};
  curves.offsets = {0, 2, 4};
  curves.materials = {0, 0};
  const auto validate = [](const Curves& changed) {
    Scene scene = valid_scene();
    scene.prototypes[0].shapes[0] = changed;
    validate_scene(scene);
  };
  EXPECT_NO_THROW(validate(curves));
  Curves broken = curves;
  broken.points[3].w = 0;
  EXPECT_ERROR(validate(broken), ErrorKind::input, "strand 1: has a radius");
  broken = curves;
  broken.points[1] = broken.points[0];
  EXPECT_ERROR(validate(broken), ErrorKind::input, "strand 0: has two equal");
  broken = curves;
  broken.offsets[1] = 3;
  EXPECT_ERROR(validate(broken), ErrorKind::input, "strand 1: has < 2 points");
  broken = curves;
  broken.offsets[2] = 3;
  EXPECT_ERROR(validate(broken), ErrorKind::input, "do not cover the points");
}

TEST(WorldBounds, HoldEveryInstanceAndTheStrandsRadius) {
  Scene scene = valid_scene();
  Curves curves;
  curves.points = {{0, 0, 0, 0.5f}, {0, 4, 0, 0.25f}};
  curves.offsets = {0, 2};
  curves.materials = {0};
  scene.prototypes[0].shapes[0] = curves;
  scene.instances.push_back(scene.instances[0]);
  scene.instances[1].world_from_local[3] = vec3(10, 0, 0);
  const Bounds bounds = world_bounds(scene);
  EXPECT_EQ(bounds.low, vec3(-0.5f, -0.5f, -0.5f));
  EXPECT_EQ(bounds.high, vec3(10.5f, 4.25f, 0.5f));
  EXPECT_EQ(count_scene(scene).segments, 1u);
  EXPECT_EQ(count_scene(scene).instanced_segments, 2u);
}

}  // namespace
}  // namespace relume

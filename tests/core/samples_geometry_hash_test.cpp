#include <gtest/gtest.h>

#include <functional>

#include "core/samples/geometry_hash.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

/// A quad with a cut-out, the scene's only texture, and a strand.
Scene make_cut_out_scene() {
  Scene scene = make_plane_scene(1, vec3(0.5f), 8, 8);
  scene.textures.push_back({"mask", 1, 2, false, {0, 0, 0, 0, 255, 255, 255, 255}});
  scene.materials[0].alpha_texture = 0;
  add_shape(scene, make_strand({0, 0, 0}, {0, 1, 0}, 0.01f, 2, add_material(scene, "kajiya-kay")));
  return scene;
}

TEST(GeometryHash, ChangesWithAllThatAShadowDependsOn) {
  const uint64_t before = geometry_hash(make_cut_out_scene());
  const std::vector<std::function<void(Scene&)>> changes = {
      [](Scene& s) { s.textures[0].texels[3] = 255; },
      [](Scene& s) { s.textures[0].width = 2; },
      [](Scene& s) { s.materials[0].alpha_texture = -1; },
      [](Scene& s) { s.materials[0].alpha_cutoff += 0.25f; },
      [](Scene& s) { s.materials[0].alpha_from_luminance = !s.materials[0].alpha_from_luminance; },
      [](Scene& s) { std::get<Mesh>(s.prototypes[0].shapes[0]).positions[0].x += 0.5f; },
      [](Scene& s) { std::swap(s.prototypes[0].shapes, s.prototypes[1].shapes); },
      [](Scene& s) { std::get<Curves>(s.prototypes[1].shapes[0]).points[0].w *= 2; },
      [](Scene& s) { s.instances[1].world_from_local[3].y += 1; },
      [](Scene& s) { s.instances.pop_back(); },
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    Scene scene = make_cut_out_scene();
    changes[i](scene);
    EXPECT_NE(geometry_hash(scene), before) << "change " << i;
  }
}

TEST(GeometryHash, IsThatOfTheGeometryAlone) {
  Scene scene = make_cut_out_scene();
  const uint64_t before = geometry_hash(scene);
  scene.lights.push_back(make_point_light({1, 2, 3}));
  scene.materials[0].parameters[0].value = vec3(0.9f);
  scene.width = 17;
  scene.camera.eye.x += 1;
  EXPECT_EQ(geometry_hash(scene), before);
}

}  // namespace
}  // namespace relume

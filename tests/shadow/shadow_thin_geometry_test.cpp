#include <gtest/gtest.h>

#include "shadow/thin_geometry.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

/// A floor, a ball, a strand and a small leaf, each a prototype placed once.
Scene make_mixed_scene() {
  Scene scene = make_empty_scene(make_camera({0, 1, 5}, vec3(0), 40), 64, 64);
  const uint32_t material = add_material(scene, "lambert");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_quad(vec3(0), {0, 0, 4}, {4, 0, 0}, material));
  add_shape(scene, make_sphere({0, 1, 0}, 0.8f, 16, material));
  add_shape(scene, make_strand({0, 0, 1}, {0, 1, 1}, 0.005f, 4, hair));
  add_shape(scene, make_quad({1, 1, 0}, {0.05f, 0, 0}, {0, 0.02f, 0}, material));
  return scene;
}

size_t solid_shapes(const ThinGeometry& geometry) {
  size_t count = 0;
  for (const Prototype& prototype : geometry.solids.prototypes) count += prototype.shapes.size();
  return count;
}

TEST(ThinGeometry, SplitsStrandsAndLeavesFromSolids) {
  const Scene scene = make_mixed_scene();
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 8);
  ASSERT_EQ(geometry.shapes.size(), 2u);
  EXPECT_EQ(geometry.instances.size(), 2u);
  EXPECT_TRUE(geometry.shapes[0].is_strands);
  EXPECT_EQ(geometry.shapes[0].pieces.size(), 1u);
  EXPECT_FALSE(geometry.shapes[1].is_strands);
  EXPECT_EQ(geometry.shapes[1].triangles.size(), 2u);
  EXPECT_EQ(geometry.shapes[1].pieces.size(), 1u) << "two triangles of one leaf";
  EXPECT_EQ(solid_shapes(geometry), 2u);
  // Strands are thin however wide they are.
  EXPECT_EQ(solid_shapes(make_thin_geometry(scene, 64, 1e6f)), 0u);
  EXPECT_EQ(make_thin_geometry(scene, 64, 0).shapes.size(), 1u);
}

TEST(ThinGeometry, DoesNotDependOnScale) {
  for (const float scale : {1e-6f, 1e6f}) {
    const Scene moved = move_scene(make_mixed_scene(), scale, vec3(0));
    EXPECT_EQ(make_thin_geometry(moved, 64, 8).shapes.size(), 2u) << scale;
  }
}

TEST(ThinGeometry, KeepsPrototypesOnce) {
  Scene scene = make_mixed_scene();
  const auto leaf = static_cast<uint32_t>(scene.prototypes.size() - 1);
  for (int i = 0; i < 100; ++i) {
    scene.instances.push_back({leaf, make_similarity(1, {0, 0.01f * static_cast<float>(i), 0})});
  }
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 8);
  EXPECT_EQ(geometry.shapes.size(), 2u);
  EXPECT_EQ(geometry.instances.size(), 102u);
  for (size_t i = 1; i < geometry.instances.size(); ++i) {
    EXPECT_EQ(geometry.instances[i].first_piece, i) << "pieces are told apart";
  }
}

TEST(ThinGeometry, DrawsSolidsWhereTheyAreFew) {
  Scene scene = make_mixed_scene();
  const uint64_t solids = make_sphere({0, 1, 0}, 0.8f, 16, 0).triangles.size() + 2;
  EXPECT_EQ(solid_shapes(make_thin_geometry(scene, 64, 8, solids - 1)), 2u);
  EXPECT_EQ(solid_shapes(make_thin_geometry(scene, 64, 8, solids)), 0u);
  scene.textures.emplace_back();
  scene.textures.back().width = scene.textures.back().height = 1;
  scene.textures.back().texels = {255, 255, 255, 255};
  for (Material& material : scene.materials) material.alpha_texture = 0;
  EXPECT_EQ(solid_shapes(make_thin_geometry(scene, 64, 8, solids)), 2u)
      << "the mean of a large mask is no shadow";
}

TEST(ThinGeometry, CutOutsCountByThePartThatIsLeft) {
  Scene scene = make_mixed_scene();
  Texture mask;
  mask.width = 2;
  mask.height = 1;
  mask.srgb = false;
  mask.texels = {255, 255, 255, 0, 255, 255, 255, 255};  // the right half is there
  scene.textures.push_back(mask);
  const uint32_t material = add_material(scene, "lambert");
  scene.materials[material].alpha_texture = 0;
  add_shape(scene, make_quad({1, 1, 0}, {0.05f, 0, 0}, {0, 0.02f, 0}, material));
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 8);
  const ThinShape& shape = geometry.shapes.back();
  ASSERT_EQ(shape.opacity.size(), 2u);
  EXPECT_NEAR(0.5f * (shape.opacity[0] + shape.opacity[1]), 0.5f, 0.1f);
}

}  // namespace
}  // namespace relume

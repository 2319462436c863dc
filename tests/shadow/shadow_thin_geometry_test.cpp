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

/// Which pieces of a mesh are sheets, where all of it counts as thin.
std::vector<bool> sheets_of(const Mesh& mesh) {
  Scene scene = make_empty_scene(make_camera({0, 1, 5}, vec3(0), 40), 64, 64);
  add_material(scene, "leaf");
  add_shape(scene, mesh);
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 1e6f);
  std::vector<bool> sheets;
  for (const ThinPiece& piece : geometry.shapes.at(0).pieces) sheets.push_back(piece.is_sheet);
  return sheets;
}

TEST(ThinGeometry, LeavesOfAnyOutlineAreSheets) {
  for (int corners = 3; corners <= 24; ++corners) {
    // From a corner of a polygon and half a polygon, whose longest side may stand anywhere.
    for (const float turn : {2 * pi, pi}) {
      for (int start = 0; start < corners; ++start) {
        Mesh mesh;
        const int parts = turn > 4 ? corners : corners - 1;
        for (int i = 0; i < corners; ++i) {
          const float angle =
              turn * static_cast<float>((start + i) % corners) / static_cast<float>(parts);
          mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
        }
        for (uint32_t i = 1; i + 1 < static_cast<uint32_t>(corners); ++i) {
          mesh.triangles.emplace_back(0, i, i + 1);
        }
        mesh.materials.assign(mesh.triangles.size(), 0);
        EXPECT_EQ(sheets_of(mesh), std::vector<bool>{true}) << corners << " from " << start;
      }
    }
  }
}

TEST(ThinGeometry, TubesThatAreLongerThanWideAreNoSheets) {
  constexpr uint32_t sides = 8;
  for (const float length : {0.7f, 3.0f, 100.0f}) {  // around it is 0.61
    Mesh mesh;
    for (uint32_t i = 0; i < sides; ++i) {
      const float angle = 2 * pi * static_cast<float>(i) / sides;
      for (const float y : {0.0f, length}) {
        mesh.positions.emplace_back(0.1f * std::cos(angle), y, 0.1f * std::sin(angle));
      }
    }
    for (uint32_t i = 0; i < 2 * sides; i += 2) {
      const uint32_t next = (i + 2) % (2 * sides);
      mesh.triangles.emplace_back(i, i + 1, next + 1);
      mesh.triangles.emplace_back(next, i, next + 1);
    }
    mesh.materials.assign(mesh.triangles.size(), 0);
    EXPECT_EQ(sheets_of(mesh), std::vector<bool>{false}) << length;
  }
}

TEST(ThinGeometry, WidthIsAreaOverDiameter) {
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    Scene scene = make_empty_scene(make_camera({0, 0, 5 * scale}, vec3(0), 40), 64, 64);
    const uint32_t material = add_material(scene, "lambert");
    add_shape(scene, make_quad(vec3(0), {0.4f * scale, 0, 0}, {0, 0.3f * scale, 0}, material));
    const float width = 0.48f / 1.0f;  // 0.8 x 0.6 over its diagonal
    const float pixel = 2 * 5 * std::tan(radians_from_degrees(20)) / 64;
    EXPECT_EQ(make_thin_geometry(scene, 64, 1.01f * width / pixel).shapes.size(), 1u) << scale;
    EXPECT_EQ(make_thin_geometry(scene, 64, 0.99f * width / pixel).shapes.size(), 0u) << scale;
  }
}

TEST(ThinGeometry, ChunksHoldStrandsThatStandTogether) {
  Curves curves;
  curves.offsets.push_back(0);
  for (int i = 0; i < 3000; ++i) {  // in turn here and there
    const vec3 root((i % 2 == 0 ? -1.0f : 1.0f) + 1e-5f * static_cast<float>(i), 0, 0);
    curves.points.emplace_back(root, 0.001f);
    curves.points.emplace_back(root + vec3(0, 0.1f, 0), 0.001f);
    curves.offsets.push_back(static_cast<uint32_t>(curves.points.size()));
    curves.materials.push_back(0);
  }
  Scene scene = make_empty_scene(make_camera({0, 1, 5}, vec3(0), 40), 64, 64);
  add_material(scene, "kajiya-kay");
  add_shape(scene, curves);
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 8);
  const std::vector<ThinChunk>& chunks = geometry.shapes.at(0).chunks;
  EXPECT_GE(chunks.size(), 5u);
  size_t wide = 0;
  uint32_t pieces = 0;
  for (const ThinChunk& chunk : chunks) {
    wide += chunk.bounds.high.x - chunk.bounds.low.x > 1 ? 1 : 0;
    pieces += chunk.piece_count;
  }
  EXPECT_LE(wide, 1u) << "between here and there";
  EXPECT_EQ(pieces, 3000u);
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

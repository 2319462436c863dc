#include <gtest/gtest.h>

#include "shadow/thin_geometry.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

/// A blade that bends over a quarter of a circle of radius 1, 16 x 1 quads, 0.1 wide.
Mesh make_bent_blade(uint32_t material) {
  constexpr uint32_t steps = 16;
  Mesh mesh;
  for (uint32_t i = 0; i <= steps; ++i) {
    const float angle = 0.5f * pi * static_cast<float>(i) / steps;
    for (const float side : {-0.05f, 0.05f}) {
      mesh.positions.emplace_back(std::cos(angle), std::sin(angle), side);
    }
  }
  for (uint32_t i = 0; i < 2 * steps; i += 2) {
    mesh.triangles.emplace_back(i, i + 1, i + 3);
    mesh.triangles.emplace_back(i, i + 3, i + 2);
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

/// Area of triangles, each times its opacity.
template <class Shape>
double covered_area(const Shape& shape) {
  double area = 0;
  for (size_t i = 0; i < shape.triangles.size(); ++i) {
    const uvec3 t = shape.triangles[i];
    const vec3 a(shape.vertices[t.x]);
    const vec3 n = glm::cross(vec3(shape.vertices[t.y]) - a, vec3(shape.vertices[t.z]) - a);
    area += 0.5 * static_cast<double>(glm::length(n)) *
            (shape.opacity.empty() ? 1.0 : static_cast<double>(shape.opacity[i]));
  }
  return area;
}

TEST(ThinLevels, KeepAreaAndStayWithinTheirError) {
  Scene scene = make_empty_scene(make_camera({0, 1, 5}, vec3(0), 40), 64, 64);
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_bent_blade(material));
  const ThinGeometry geometry = make_thin_geometry(scene, 64);
  ASSERT_EQ(geometry.shapes.size(), 1u);
  const ThinShape& shape = geometry.shapes[0];
  EXPECT_TRUE(shape.pieces[0].is_sheet);
  ASSERT_GE(shape.levels.size(), 2u);
  size_t last = shape.triangles.size();
  float last_error = 0;
  for (const ThinLevel& level : shape.levels) {
    EXPECT_LT(level.triangles.size(), last);
    EXPECT_EQ(level.pieces.size(), shape.pieces.size());
    EXPECT_NEAR(covered_area(level), covered_area(shape), 1e-4);
    ASSERT_EQ(level.error.size(), shape.pieces.size());
    EXPECT_GE(level.error[0], last_error);
    // Chords of the circle: their middles are the farthest from it.
    for (const uvec3 t : level.triangles) {
      const vec3 corners[3] = {vec3(level.vertices[t.x]), vec3(level.vertices[t.y]),
                               vec3(level.vertices[t.z])};
      for (int i = 0; i < 3; ++i) {
        const vec3 middle = 0.5f * (corners[i] + corners[(i + 1) % 3]);
        EXPECT_LE(1 - std::hypot(middle.x, middle.y), level.error[0] + 2e-3f);
      }
    }
    last = level.triangles.size();
    last_error = level.error[0];
  }
  EXPECT_GT(last_error, 0);
}

/// A star of two faces that share their rim: a closed body, as thin as paper. Its inner corners lie
/// at 0.4 of the outer ones.
Mesh make_star(uint32_t material) {
  constexpr uint32_t corners = 14;
  Mesh mesh;
  for (uint32_t i = 0; i < corners; ++i) {
    const float angle = 2 * pi * static_cast<float>(i) / corners;
    const float radius = i % 2 == 0 ? 1.0f : 0.4f;
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  mesh.positions.emplace_back(0, 0, 0.001f);
  mesh.positions.emplace_back(0, 0, -0.001f);
  for (uint32_t i = 0; i < corners; ++i) {
    mesh.triangles.emplace_back(corners, i, (i + 1) % corners);
    mesh.triangles.emplace_back(corners + 1, (i + 1) % corners, i);
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

TEST(ThinLevels, OfLeavesWithTwoFacesFillNoBays) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 64, 64);
  const uint32_t material = add_material(scene, "leaf");
  add_shape(scene, make_star(material));
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 64);
  ASSERT_EQ(geometry.shapes.size(), 1u);
  const ThinShape& shape = geometry.shapes[0];
  EXPECT_FALSE(shape.pieces[0].is_sheet);
  ASSERT_GE(shape.levels.size(), 1u);
  for (const ThinLevel& level : shape.levels) {
    EXPECT_NEAR(covered_area(level), covered_area(shape), 1e-4);
    double area = 0;
    for (const uvec3 t : level.triangles) {
      const vec3 a(level.vertices[t.x]);
      const vec3 n = glm::cross(vec3(level.vertices[t.y]) - a, vec3(level.vertices[t.z]) - a);
      area += 0.5 * static_cast<double>(glm::length(n));
    }
    EXPECT_GE(area, 0.69 * covered_area(shape));
    // Who spans a bay says so: its bottom is more than 0.4 from the chord.
    if (level.error[0] < 0.2f) {
      EXPECT_LE(area, 1.02 * covered_area(shape));
    }
  }
}

/// A flat disc of one face, a fan of 24 triangles.
Mesh make_disc(uint32_t material) {
  constexpr uint32_t corners = 24;
  Mesh mesh;
  for (uint32_t i = 0; i < corners; ++i) {
    const float angle = 2 * pi * static_cast<float>(i) / corners;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  mesh.positions.emplace_back(0, 0, 0);
  for (uint32_t i = 0; i < corners; ++i) mesh.triangles.emplace_back(corners, i, (i + 1) % corners);
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

TEST(ThinLevels, AreTheSameAtAnyScale) {
  // By powers of two, so that every step rounds alike.
  const auto shape_of = [](const Mesh& mesh, float scale) {
    Scene scene = make_empty_scene(make_camera({0, 0, 5 * scale}, vec3(0), 40), 64, 64);
    add_material(scene, "leaf");
    Mesh scaled = mesh;
    for (vec3& p : scaled.positions) p *= scale;
    add_shape(scene, scaled);
    return make_thin_geometry(scene, 64, 64).shapes.at(0);
  };
  for (const Mesh& mesh : {make_star(0), make_bent_blade(0), make_disc(0)}) {
    const ThinShape expected = shape_of(mesh, 1);
    for (const float scale : {0x1p-10f, 0x1p10f}) {
      const ThinShape found = shape_of(mesh, scale);
      ASSERT_EQ(found.levels.size(), expected.levels.size()) << scale;
      for (size_t i = 0; i < found.levels.size(); ++i) {
        EXPECT_EQ(found.levels[i].triangles, expected.levels[i].triangles);
        EXPECT_EQ(found.levels[i].opacity, expected.levels[i].opacity);
        EXPECT_EQ(found.levels[i].error[0], scale * expected.levels[i].error[0]);
      }
    }
  }
}

TEST(ThinLevels, AreAtMostSixAndEachIsMuchSmaller) {
  // A flat grid of 16 x 16 quads: every vertex may go.
  constexpr uint32_t side = 17;
  Mesh mesh;
  for (uint32_t i = 0; i < side * side; ++i) {
    mesh.positions.emplace_back(static_cast<float>(i % side), static_cast<float>(i / side), 0);
  }
  for (uint32_t i = 0; i + side + 1 < side * side; ++i) {
    if (i % side == side - 1) continue;
    mesh.triangles.emplace_back(i, i + 1, i + side + 1);
    mesh.triangles.emplace_back(i, i + side + 1, i + side);
  }
  mesh.materials.assign(mesh.triangles.size(), 0);
  Scene scene = make_empty_scene(make_camera({8, 8, 50}, {8, 8, 0}, 40), 64, 64);
  add_material(scene, "leaf");
  add_shape(scene, mesh);
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 64);
  const ThinShape& shape = geometry.shapes.at(0);
  EXPECT_EQ(shape.levels.size(), 6u);
  size_t last = shape.triangles.size();
  ASSERT_EQ(last, 512u);
  for (const ThinLevel& level : shape.levels) {
    EXPECT_LE(static_cast<double>(level.triangles.size()), 0.6 * static_cast<double>(last));
    last = level.triangles.size();
  }
  EXPECT_GT(last, 3u) << "a seventh could follow";
}

TEST(ThinLevels, LeaveSolidsThatAreDrawnAsTheyAre) {
  Scene scene = make_empty_scene(make_camera({0, 1, 5}, vec3(0), 40), 64, 64);
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_sphere({0, 1, 0}, 0.8f, 32, material));
  const ThinGeometry geometry = make_thin_geometry(scene, 64, 8, 100000);
  ASSERT_EQ(geometry.shapes.size(), 1u);
  EXPECT_FALSE(geometry.shapes[0].pieces[0].is_sheet);
  EXPECT_TRUE(geometry.shapes[0].levels.empty());
}

}  // namespace
}  // namespace relume

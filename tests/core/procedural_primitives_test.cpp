#include <gtest/gtest.h>

#include <cmath>

#include "core/scene/limits.h"
#include "core/scene/procedural/generators.h"

namespace relume {
namespace {

double area_of(const Mesh& mesh) {
  double area = 0;
  for (const uvec3& t : mesh.triangles) {
    const dvec3 a(mesh.positions[t.x]);
    area += 0.5 *
            glm::length(glm::cross(dvec3(mesh.positions[t.y]) - a, dvec3(mesh.positions[t.z]) - a));
  }
  return area;
}

/// Signed volume of a closed mesh; positive when its faces turn outwards.
double volume_of(const Mesh& mesh) {
  double volume = 0;
  for (const uvec3& t : mesh.triangles) {
    volume += glm::dot(dvec3(mesh.positions[t.x]),
                       glm::cross(dvec3(mesh.positions[t.y]), dvec3(mesh.positions[t.z]))) /
              6;
  }
  return volume;
}

void expect_sound(const Mesh& mesh, uint32_t material) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  ASSERT_EQ(mesh.materials.size(), mesh.triangles.size());
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uvec3& t = mesh.triangles[i];
    const vec3 a = mesh.positions[t.x];
    const vec3 b = mesh.positions[t.y];
    const vec3 c = mesh.positions[t.z];
    ASSERT_TRUE(has_area(a, b, c)) << "triangle " << i;
    const vec3 face = glm::cross(b - a, c - a);
    ASSERT_GT(glm::dot(face, mesh.normals[t.x]), 0) << "triangle " << i << " turns inwards";
    ASSERT_EQ(mesh.materials[i], material);
  }
  for (size_t i = 0; i < mesh.normals.size(); ++i) {
    ASSERT_NEAR(glm::length(mesh.normals[i]), 1, 1e-6) << "normal " << i;
    ASSERT_GE(std::min(mesh.uvs[i].x, mesh.uvs[i].y), 0) << "vertex " << i;
    ASSERT_LE(std::max(mesh.uvs[i].x, mesh.uvs[i].y), 1) << "vertex " << i;
  }
}

TEST(Sphere, HasAnalyticNormalsAndClosedFormMeasures) {
  const SphereParams params{{1, -2, 3}, 0.75f, 64, 5};
  Mesh mesh = make_sphere(params);
  expect_sound(mesh, 5);
  EXPECT_EQ(mesh.triangles.size(), 2u * 128u * 63u) << "two a quad, one at the poles";
  for (size_t i = 0; i < mesh.positions.size(); ++i) {
    const vec3 radial = (mesh.positions[i] - params.center) / params.radius;
    ASSERT_NEAR(glm::length(radial), 1, 1e-6);
    ASSERT_LT(glm::length(radial - mesh.normals[i]), 1e-6) << "vertex " << i;
  }
  EXPECT_NEAR(area_of(mesh), 4 * 3.14159265 * 0.75 * 0.75, 0.01);
  for (vec3& p : mesh.positions) p -= params.center;
  EXPECT_NEAR(volume_of(mesh), 4.0 / 3 * 3.14159265 * std::pow(0.75, 3), 0.005);
}

TEST(Sphere, KeepsItsInvariantsAtTheExtremes) {
  expect_sound(make_sphere({vec3(0), 1e-6f, 3, 0}), 0);
  expect_sound(make_sphere({vec3(0), 1e6f, 300, 0}), 0);
  // So far out that small triangles round to lines: they are left out.
  const Mesh coarse = make_sphere({{1e4f, 0, 0}, 0.5f, 256, 0});
  for (const uvec3& t : coarse.triangles) {
    ASSERT_TRUE(has_area(coarse.positions[t.x], coarse.positions[t.y], coarse.positions[t.z]));
  }
}

TEST(Plane, IsARectangleThatFacesUp) {
  const Mesh mesh = make_plane({1, 2, 3}, {4, 0.5f}, 7);
  expect_sound(mesh, 7);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_NEAR(area_of(mesh), 8, 1e-9);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(mesh.normals[i], vec3(0, 1, 0));
    EXPECT_EQ(mesh.positions[i].y, 2);
    EXPECT_EQ(std::abs(mesh.positions[i].x - 1), 4);
    EXPECT_EQ(std::abs(mesh.positions[i].z - 3), 0.5f);
  }
}

TEST(Box, IsClosedAndFacesOutwards) {
  Mesh mesh = make_box({5, 6, 7}, {1, 2, 3}, 2);
  expect_sound(mesh, 2);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_NEAR(area_of(mesh), 8 * (1 * 2 + 2 * 3 + 3 * 1), 1e-9);
  for (vec3& p : mesh.positions) p -= vec3(5, 6, 7);
  EXPECT_NEAR(volume_of(mesh), 48, 1e-9);
}

}  // namespace
}  // namespace relume

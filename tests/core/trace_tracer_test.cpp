#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/trace/ray_bias.h"
#include "core/trace/tracer.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

Ray ray_from(vec3 origin, vec3 direction) {
  return {.origin = origin, .direction = direction};
}

Scene make_base() {
  return make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
}

TEST(Tracer, FindsTheNearerOfTwoQuads) {
  Scene scene = make_base();
  const uint32_t far = add_material(scene, "lambert");
  const uint32_t near = add_material(scene, "lambert");
  add_shape(scene, make_quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, far));
  add_shape(scene, make_quad({0, 0, 1}, {1, 0, 0}, {0, 1, 0}, near));
  const Tracer tracer(scene);
  const auto hit = tracer.intersect(ray_from({0.25f, 0.5f, 5}, {0, 0, -1}));
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(hit->material, near);
  EXPECT_EQ(hit->position, vec3(0.25f, 0.5f, 1));
  EXPECT_EQ(hit->geometric_normal, vec3(0, 0, 1));
  EXPECT_EQ(hit->shading_normal, vec3(0, 0, 1));
  EXPECT_EQ(hit->tangent, vec3(0));
  EXPECT_NEAR(hit->uv.x, 0.625, 1e-6);
  EXPECT_NEAR(hit->uv.y, 0.75, 1e-6);
  EXPECT_FALSE(tracer.intersect(ray_from({1.5f, 0, 5}, {0, 0, -1})).has_value());
  EXPECT_FALSE(tracer.intersect(ray_from({0, 0, 5}, {0, 0, 1})).has_value());
}

TEST(Tracer, NormalsFaceTheRayFromBothSides) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_quad(vec3(0), {1, 0, 0}, {0, 1, 0}, material));
  const Tracer tracer(scene);
  EXPECT_EQ(tracer.intersect(ray_from({0, 0.1f, -5}, {0, 0, 1}))->geometric_normal, vec3(0, 0, -1));
  EXPECT_EQ(tracer.intersect(ray_from({0, 0.1f, 5}, {0, 0, -1}))->geometric_normal, vec3(0, 0, 1));
}

TEST(Tracer, SphereNormalsAreTheSpheres) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_sphere({1, 2, 3}, 2, 64, material));
  const Tracer tracer(scene);
  Random random(1, RandomStream::tests, 0);
  for (int i = 0; i < 500; ++i) {
    const vec3 outward = random_direction(random);
    const auto hit = tracer.intersect(ray_from(vec3(1, 2, 3) + 5.0f * outward, -outward));
    ASSERT_TRUE(hit.has_value());
    EXPECT_GT(glm::dot(hit->shading_normal, outward), 0.9999f);
    EXPECT_NEAR(glm::length(hit->position - vec3(1, 2, 3)), 2, 5e-3);
    const auto inside = tracer.intersect(ray_from({1, 2, 3}, outward));
    ASSERT_TRUE(inside.has_value());
    EXPECT_LT(glm::dot(inside->shading_normal, outward), -0.9999f);
  }
}

TEST(Tracer, ShadingNormalsNeverFaceAwayFromTheEye) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_sphere(vec3(0), 1, 6, material));
  const Tracer tracer(scene);
  const CameraRays rays(scene.camera, 200, 200);
  int hits = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const Ray ray = ray_from(rays.eye(), rays.direction(vec2(x, y) + 0.5f));
      const auto hit = tracer.intersect(ray);
      if (!hit) continue;
      ++hits;
      EXPECT_GT(glm::dot(hit->shading_normal, -ray.direction), 0) << x << " " << y;
      EXPECT_NEAR(glm::length(hit->shading_normal), 1, 1e-6) << x << " " << y;
    }
  }
  EXPECT_GT(hits, 1000);
}

TEST(Tracer, OcclusionEndsWhereTheRayEnds) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "lambert");
  add_shape(scene, make_quad(vec3(0), {1, 0, 0}, {0, 1, 0}, material));
  const Tracer tracer(scene);
  Ray ray = ray_from({0.1f, 0.2f, 1}, {0, 0, -1});
  EXPECT_TRUE(tracer.occluded(ray));
  ray.t_far = 0.99f;
  EXPECT_FALSE(tracer.occluded(ray));
  ray.t_far = 1.01f;
  EXPECT_TRUE(tracer.occluded(ray));
  ray.t_near = 1.005f;
  EXPECT_FALSE(tracer.occluded(ray));
  ray.t_near = 2;
  EXPECT_FALSE(tracer.occluded(ray));
  ray.t_far = std::nanf("");
  EXPECT_FALSE(tracer.occluded(ray));
}

/// A quad whose left half is cut out.
Scene make_cut_out_scene(bool luminance) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "lambert");
  const uint8_t on = 255;
  scene.textures.push_back({"mask", 2, 1, false, {0, 0, 0, 0, on, on, on, on}});
  if (luminance) scene.textures[0].texels[3] = on;
  scene.materials[material].alpha_texture = 0;
  scene.materials[material].alpha_from_luminance = luminance;
  add_shape(scene, make_quad(vec3(0), {1, 0, 0}, {0, 1, 0}, material));
  return scene;
}

class CutOut : public testing::TestWithParam<bool> {};

TEST_P(CutOut, LetsViewAndShadowRaysThrough) {
  Scene scene = make_cut_out_scene(GetParam());
  for (const Instancing instancing : {Instancing::flatten, Instancing::instance}) {
    scene.instancing = instancing;
    scene.instances.resize(1);
    scene.instances.push_back({0, make_similarity(1, {0, 0, -100})});
    const Tracer tracer(scene);
    for (const float x : {-0.9f, -0.5f, -0.3f, 0.3f, 0.5f, 0.9f}) {
      Ray ray = ray_from({x, 0.3f, 5}, {0, 0, -1});
      ray.t_far = 50;
      EXPECT_EQ(tracer.intersect(ray).has_value(), x > 0) << x;
      EXPECT_EQ(tracer.occluded(ray), x > 0) << x;
    }
  }
}

TEST_P(CutOut, CutoffZeroKeepsEverything) {
  Scene scene = make_cut_out_scene(GetParam());
  scene.materials[0].alpha_cutoff = 0;
  const Tracer tracer(scene);
  EXPECT_TRUE(tracer.intersect(ray_from({-0.5f, 0, 5}, {0, 0, -1})).has_value());
}

INSTANTIATE_TEST_SUITE_P(AlphaOrLuminance, CutOut, testing::Bool());

TEST(Tracer, StrandHitsCarryTangentColourAndBias) {
  Scene scene = make_base();
  const uint32_t material = add_material(scene, "kajiya-kay");
  Curves curves = make_strand({0, -1, 0}, {0, 1, 0}, 0.1f, 3, material);
  // A second strand: its segments must find their own strand and points.
  const Curves second = make_strand({1, 2, 0}, {1, -2, 0}, 0.2f, 2, material);
  curves.points.insert(curves.points.end(), second.points.begin(), second.points.end());
  curves.offsets.push_back(static_cast<uint32_t>(curves.points.size()));
  curves.materials.push_back(material);
  curves.colors = {vec3(1, 0, 0), vec3(0, 1, 0)};
  add_shape(scene, curves);
  const Tracer tracer(scene);
  const auto first_hit = tracer.intersect(ray_from({0.05f, 0.9f, 5}, {0, 0, -1}));
  ASSERT_TRUE(first_hit.has_value());
  EXPECT_EQ(first_hit->color_scale, vec3(1, 0, 0));
  EXPECT_NEAR(first_hit->tangent.y, 1, 1e-6);
  EXPECT_FLOAT_EQ(first_hit->bias, strand_bias(0.1f));
  EXPECT_EQ(first_hit->geometric_normal, vec3(0));
  EXPECT_NEAR(first_hit->position.y, 0.9, 1e-5);
  for (const float y : {1.5f, 0.5f, -0.5f, -1.5f}) {
    const auto hit = tracer.intersect(ray_from({1.15f, y, 5}, {0, 0, -1}));
    ASSERT_TRUE(hit.has_value()) << y;
    EXPECT_EQ(hit->color_scale, vec3(0, 1, 0)) << y;
    EXPECT_NEAR(hit->tangent.y, -1, 1e-6) << y;
    EXPECT_FLOAT_EQ(hit->bias, strand_bias(0.2f)) << y;
  }
  EXPECT_FALSE(tracer.intersect(ray_from({0.11f, 0, 5}, {0, 0, -1})).has_value());
}

TEST(Tracer, StrandPointsLieOnTheirAxis) {
  // The ribbon that a ray meets turns with the ray: only the axis is a place of its own, and from
  // there a strand cannot shadow its own straight run whatever the light's angle.
  Scene scene = make_base();
  add_shape(scene, make_strand({0, -1, 0}, {0, 1, 0}, 0.1f, 4, add_material(scene, "kajiya-kay")));
  const Tracer tracer(scene);
  for (const float x : {-0.09f, -0.04f, 0.0f, 0.07f}) {
    const auto hit = tracer.intersect(ray_from({x, 0.3f, 5}, {0, 0, -1}));
    ASSERT_TRUE(hit.has_value());
    EXPECT_NEAR(hit->position.x, 0, 1e-6) << x;
    EXPECT_NEAR(hit->position.y, 0.3f, 1e-6) << x;
    EXPECT_NEAR(hit->position.z, 0, 1e-6) << x;
  }
}

/// Two prototypes under rotated, scaled and mirrored instances.
Scene make_instanced_scene(Instancing instancing) {
  Scene scene = make_base();
  scene.instancing = instancing;
  const uint32_t surface = add_material(scene, "lambert");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_sphere(vec3(0), 0.5f, 16, surface));
  add_shape(scene, make_strand({0, -0.5f, 0}, {0.2f, 0.5f, 0.1f}, 0.05f, 4, hair));
  scene.instances.clear();
  Random random(6, RandomStream::tests, 0);
  for (uint32_t i = 0; i < 20; ++i) {
    const vec3 axis = random_direction(random);
    const vec3 side = normalize_or(glm::cross(axis, vec3(0.3f, 0.5f, 0.8f)), {1, 0, 0});
    const float scale = random.uniform(0.5f, 1.5f);
    const float mirror = i % 4 < 2 ? scale : -scale;
    const float x = random.uniform(-1.5f, 1.5f);
    const float y = random.uniform(-1.5f, 1.5f);
    scene.instances.push_back({i % 2, mat4x3(scale * axis, scale * side,
                                             mirror * glm::cross(axis, side), vec3(x, y, 0))});
  }
  return scene;
}

TEST(Tracer, InstancedAndFlattenedScenesAgree) {
  const Scene flat_scene = make_instanced_scene(Instancing::flatten);
  const Scene instanced_scene = make_instanced_scene(Instancing::instance);
  const Tracer flat(flat_scene);
  const Tracer instanced(instanced_scene);
  EXPECT_TRUE(flat.stats().flattened);
  EXPECT_FALSE(instanced.stats().flattened);
  const CameraRays rays(flat_scene.camera, 160, 160);
  int hits = 0;
  int different = 0;
  for (int i = 0; i < 160 * 160; ++i) {
    const Ray ray = ray_from(rays.eye(), rays.direction(vec2(i % 160, i / 160) + 0.5f));
    const auto a = flat.intersect(ray);
    const auto b = instanced.intersect(ray);
    if (a.has_value() != b.has_value() || (a && a->material != b->material)) {
      ++different;
      continue;
    }
    EXPECT_EQ(flat.occluded(ray), a.has_value());
    EXPECT_EQ(instanced.occluded(ray), b.has_value());
    if (!a || glm::length(a->position - b->position) > 1e-3f) continue;
    ++hits;
    EXPECT_GT(glm::dot(a->shading_normal, b->shading_normal), 0.999f);
    EXPECT_NEAR(glm::length(a->tangent - b->tangent), 0, 1e-4);
    EXPECT_NEAR(a->bias, b->bias, 1e-4f * a->bias);
  }
  EXPECT_GT(hits, 3000);
  EXPECT_LE(different, 10);  // rays through an outline may round either way
}

TEST(Tracer, BoundsEncloseTheScene) {
  const Scene scene = make_instanced_scene(Instancing::instance);
  const Bounds bounds = Tracer(scene).bounds();
  const Bounds world = world_bounds(scene);
  EXPECT_TRUE(glm::all(glm::greaterThanEqual(bounds.low, world.low - 1e-3f)));
  EXPECT_TRUE(glm::all(glm::lessThanEqual(bounds.high, world.high + 1e-3f)));
}

TEST(RayBias, IsRelativeToTheCoordinates) {
  const vec3 a(1, 2, 3);
  const vec3 b(-4, 0, 0);
  const vec3 c(0, 1, 0);
  const float bias = surface_bias(a, b, c);
  EXPECT_FLOAT_EQ(bias, 0x1p-17f * 4);
  for (const float scale : {1e-6f, 1e-3f, 1e3f, 1e6f}) {
    EXPECT_FLOAT_EQ(surface_bias(a * scale, b * scale, c * scale), bias * scale);
  }
  EXPECT_GT(surface_bias(vec3(0), vec3(0), vec3(0)), 0);
}

TEST(ShadowRay, StartsOnTheLightsSideAndEndsBeforeTheLight) {
  const vec3 n(0, 0, 1);
  const vec3 up = normalize_or({1, 0, 1}, n);
  const Ray above = make_shadow_ray(vec3(0), &n, 0.1f, up, 3);
  EXPECT_EQ(above.origin, vec3(0, 0, 0.1f));
  EXPECT_FLOAT_EQ(above.t_far, 2.9f);
  const Ray below = make_shadow_ray(vec3(0), &n, 0.1f, -up, 3);
  EXPECT_EQ(below.origin, vec3(0, 0, -0.1f));
  const Ray strand = make_shadow_ray(vec3(1), nullptr, 0.1f, up, 3);
  EXPECT_EQ(strand.origin, vec3(1));
  EXPECT_EQ(strand.t_near, 0.1f);
}

}  // namespace
}  // namespace relume

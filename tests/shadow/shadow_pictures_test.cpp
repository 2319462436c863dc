#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/relight/relight.h"
#include "shadow/traced.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

// Pictures with traced shadows whose answer is known.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

constexpr double pi_double = 3.14159265358979323846;

struct Picture {
  Image shadowed;
  Image unshadowed;
  std::vector<float> coverage;
};

Picture render(const Scene& scene, std::span<const Light> lights, int spp = 4) {
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, spp);
  TracedVisibility shadows(tracer);
  return {render_frame(cache, lights, &shadows), render_frame(cache, lights), cache.coverage()};
}

/// Pixels where the shadow took away something.
int darker_pixels(const Picture& picture) {
  int count = 0;
  for (size_t i = 0; i < picture.shadowed.pixel_count(); ++i) {
    if (picture.shadowed.rgb(i).y < 0.9999f * picture.unshadowed.rgb(i).y) ++count;
  }
  return count;
}

struct Placement {
  float scale;
  vec3 offset;
};

/// Scales and places at which every picture must hold.
const Placement placements[] = {{1, vec3(0)},    {1e-6f, vec3(0)}, {1e-3f, vec3(0)},
                                {1e3f, vec3(0)}, {1e6f, vec3(0)},  {1, vec3(50, -80, 30)}};

class Enclosure : public testing::TestWithParam<Placement> {};

TEST_P(Enclosure, SphereIsEvenlyLitFromItsCentre) {
  // A closed Lambert sphere with the light in its centre: every point at distance r and normal
  // incidence, so albedo / pi / r^2 everywhere: no acne, no leak.
  Scene scene = make_empty_scene(make_camera({0, 0, 0.9f}, {0, 0, 0}, 100), 64, 64);
  const uint32_t material = add_material(scene, "lambert", {{"diffuse", vec3(0.5f)}});
  add_shape(scene, make_sphere(vec3(0), 1, 256, material));
  scene.lights = {make_point_light(vec3(0), 2)};
  const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
  const Picture picture = render(moved, moved.lights);
  const double expected = 2 * 0.5 / pi_double;
  for (size_t i = 0; i < picture.shadowed.pixel_count(); ++i) {
    EXPECT_EQ(picture.coverage[i], 1.0f);
    // The tessellation itself sags by 1 - cos(pi / 512) = 2e-5 of the radius.
    ASSERT_NEAR(picture.shadowed.rgb(i).x, expected, 1e-4 * expected) << "pixel " << i;
  }
}

TEST_P(Enclosure, LightOutsideDoesNotLeakIn) {
  Scene scene = make_empty_scene(make_camera({0, 0, 0.5f}, {0, 0, 0}, 100), 64, 64);
  const uint32_t material = add_material(scene, "leaf", {{"transmit", vec3(0.5f)}});
  add_shape(scene, make_sphere(vec3(0), 1, 32, material));
  add_shape(scene, make_sphere(vec3(0), 1.02f, 32, material));
  scene.lights = {make_point_light({3, 1, 0}), make_directional_light({0.3f, -1, 0.2f}),
                  make_spot_light({0, 0, 3}, {0, 0, -1}, 20, 40)};
  const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
  const Picture picture = render(moved, moved.lights);
  EXPECT_EQ(max_difference(picture.shadowed, Image(64, 64)), 0);
  EXPECT_GT(max_difference(picture.unshadowed, Image(64, 64)), 0);
}

INSTANTIATE_TEST_SUITE_P(Placements, Enclosure, testing::ValuesIn(placements));

class ShadowEdge : public testing::TestWithParam<Placement> {};

TEST_P(ShadowEdge, FallsInItsColumn) {
  // Light at height 2 over x = 0, an occluder at height 1 over x < 0.1 (to -3): by similar
  // triangles the shadow on z = 0 covers x < 0.2.
  Scene scene = make_plane_scene(5, vec3(0.5f), 100, 20);
  add_shape(scene, make_quad({-1.45f, 0, 1}, {1.55f, 0, 0}, {0, 30, 0}, 0));
  // Seen from a place from which the occluder hides nothing of the right side.
  scene.camera = make_camera({3, 0, 3}, {0.2f, 0, 0}, 20);
  scene.lights = {make_point_light({0, 0, 2}, 1)};
  const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
  const Picture picture = render(moved, moved.lights);
  const CameraRays rays(scene.camera, 100, 20);
  int lit = 0;
  int dark = 0;
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 100; ++x) {
      const vec2 pixel = vec2(x, y) + 0.5f;
      const vec3 d = rays.direction(pixel);
      const vec3 p = rays.eye() - d * (rays.eye().z / d.z);
      const vec3 at_occluder = rays.eye() - d * ((rays.eye().z - 1) / d.z);
      if (at_occluder.x < 0.15f) continue;  // the occluder itself, or its outline
      const float half_pixel_px =
          std::abs(rays.project(p).film_px.x - rays.project({0.2f, p.y, 0}).film_px.x);
      if (half_pixel_px < 1.5f) continue;  // the edge runs through the pixel
      const size_t i = static_cast<size_t>(y) * 100 + x;
      const float seen = picture.shadowed.rgb(i).x;
      if (p.x > 0.2f) {
        EXPECT_EQ(seen, picture.unshadowed.rgb(i).x) << x << " " << y;
        EXPECT_GT(seen, 0) << x << " " << y;
        ++lit;
      } else {
        EXPECT_EQ(seen, 0) << x << " " << y;
        ++dark;
      }
    }
  }
  EXPECT_GT(lit, 500);
  EXPECT_GT(dark, 100);
}

INSTANTIATE_TEST_SUITE_P(Placements, ShadowEdge, testing::ValuesIn(placements));

class NoAcne : public testing::TestWithParam<Placement> {};

TEST_P(NoAcne, PlaneUnderGrazingLightIsFullyLit) {
  for (const float elevation : {0.5f, 0.05f, 0.005f, 0.0005f}) {
    Scene scene = make_plane_scene(2, vec3(0.5f), 60, 60);
    scene.lights = {make_directional_light({-1, 0.37f, -elevation}),
                    make_point_light({3, 0, elevation})};
    const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
    const Picture picture = render(moved, moved.lights);
    EXPECT_EQ(darker_pixels(picture), 0) << "elevation " << elevation;
  }
}

TEST_P(NoAcne, TiltedPlanesAreFullyLit) {
  for (uint64_t i = 0; i < 12; ++i) {
    Random random(4, RandomStream::tests, i);
    const vec3 n = random_direction(random);
    const vec3 u = normalize_or(glm::cross(n, vec3(0.4f, 0.2f, 0.9f)), {1, 0, 0});
    const vec3 v = glm::cross(n, u);
    Scene scene = make_empty_scene(make_camera(3.0f * n + 0.3f * u, vec3(0), 30, u), 40, 40);
    add_material(scene, "lambert");
    add_shape(scene, make_quad(vec3(0), 2.0f * u, 2.0f * v, 0));
    scene.lights = {make_directional_light(-u - 0.01f * n), make_point_light(v + 0.02f * n)};
    const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
    EXPECT_EQ(darker_pixels(render(moved, moved.lights)), 0) << i;
  }
}

TEST_P(NoAcne, SphereIsLitUpToItsTerminator) {
  Scene scene = make_empty_scene(make_camera({0, 0, 4}, vec3(0), 32), 80, 80);
  add_material(scene, "lambert");
  add_shape(scene, make_sphere(vec3(0), 1, 64, 0));
  const vec3 to_light = normalize_or({1, 0.5f, 0.5f}, {1, 0, 0});
  scene.lights = {make_directional_light(-to_light)};
  const Scene moved = move_scene(scene, GetParam().scale, GetParam().offset);
  const Picture picture = render(moved, moved.lights);
  for (size_t i = 0; i < picture.shadowed.pixel_count(); ++i) {
    const float lit = picture.unshadowed.rgb(i).x * pi / 0.5f;  // the cosine
    // A facet of 64 bands turns its back on the light up to pi / 128 before its smooth normal does.
    if (lit > 0.06f) {
      EXPECT_NEAR(picture.shadowed.rgb(i).x, picture.unshadowed.rgb(i).x, 1e-5f) << "pixel " << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Placements, NoAcne, testing::ValuesIn(placements));

TEST(FarFromTheOrigin, ShadowsStillHoldAtTenThousandRadii) {
  // Floats resolve 1e-3 of the radius here: edges blur by the bias, but nothing speckles.
  Scene scene = make_plane_scene(1, vec3(0.5f), 40, 40);
  scene.lights = {make_directional_light({-0.3f, 0, -1})};
  const Scene moved = move_scene(scene, 1, vec3(1e4f, -1e4f, 1e4f));
  const Picture picture = render(moved, moved.lights);
  EXPECT_EQ(darker_pixels(picture), 0);
  scene.lights = {make_directional_light({0, 0, -1})};
  add_shape(scene, make_quad({0, 0, 5}, {4, 0, 0}, {0, 4, 0}, 0));
  const Scene covered = move_scene(scene, 1, vec3(1e4f, -1e4f, 1e4f));
  EXPECT_EQ(max_difference(render(covered, covered.lights).shadowed, Image(40, 40)), 0);
}

TEST(CutOutShadow, IsTheMasksShadow) {
  // A quad with its left half cut out over a plane: its shadow is the right half only.
  Scene scene = make_plane_scene(5, vec3(0.5f), 60, 20);
  const uint8_t on = 255;
  scene.textures.push_back({"mask", 2, 1, false, {0, 0, 0, 0, on, on, on, on}});
  const uint32_t cut_out = add_material(scene, "lambert");
  scene.materials[cut_out].alpha_texture = 0;
  add_shape(scene, make_quad({0, 0, 4.5f}, {1, 0, 0}, {0, 3, 0}, cut_out));
  const Light light = make_directional_light({0, 0, -1});
  const Picture picture = render(scene, {&light, 1});
  const CameraRays rays(scene.camera, 60, 20);
  const float left = rays.project({-1, 0, 0}).film_px.x;
  const float middle = rays.project({0, 0, 0}).film_px.x;
  const float right = rays.project({1, 0, 0}).film_px.x;
  for (int x = 0; x < 60; ++x) {
    const float pixel = static_cast<float>(x) + 0.5f;
    if (std::min({std::abs(pixel - left), std::abs(pixel - middle), std::abs(pixel - right)}) < 1) {
      continue;
    }
    const bool shadowed = pixel > middle && pixel < right;
    EXPECT_NEAR(picture.shadowed.at(x, 10)[0], shadowed ? 0 : 0.5f / pi, 1e-5f) << x;
  }
}

/// One strand across the view.
Scene make_strand_scene(float radius, int segments) {
  Scene scene = make_empty_scene(make_camera({0, 0, 4}, vec3(0), 30), 64, 64);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_strand({-0.7f, -0.5f, 0.1f}, {0.7f, 0.6f, -0.2f}, radius, segments, hair));
  return scene;
}

class StrandSelfShadow : public testing::TestWithParam<float> {};

TEST_P(StrandSelfShadow, LightFromTheFrontReachesEverySample) {
  for (const Placement& placement : placements) {
    Scene scene = make_strand_scene(GetParam(), 8);
    scene.lights = {make_point_light({0, 0, 4}, 1), make_directional_light({0, 0, -1}),
                    make_point_light({0.5f, 1, 3}, 1)};
    const Scene moved = move_scene(scene, placement.scale, placement.offset);
    const Picture picture = render(moved, moved.lights, 16);
    EXPECT_GT(max_difference(picture.unshadowed, Image(64, 64)), 0);
    EXPECT_EQ(darker_pixels(picture), 0) << "scale " << placement.scale;
  }
}

TEST_P(StrandSelfShadow, LightFromAnySideReachesEverySample) {
  // A ribbon has no dark side. Below atan(1 / 2) = 27 degrees to the strand the end of the next
  // segment comes within a radius of rays that start shortly before it: there some samples darken.
  Scene scene = make_strand_scene(GetParam(), 8);
  const vec3 tangent = normalize_or({1.4f, 1.1f, -0.3f}, {1, 0, 0});
  const vec3 side = normalize_or(glm::cross(tangent, vec3(0, 0, 1)), {0, 1, 0});
  const vec3 front = glm::cross(side, tangent);
  for (const float from_tangent_deg : {90.0f, 75.0f, 60.0f, 45.0f, 30.0f}) {
    for (int turn = 0; turn < 8; ++turn) {
      const float a = radians_from_degrees(from_tangent_deg);
      const float b = static_cast<float>(turn) * pi / 4;
      const vec3 to_light =
          std::cos(a) * tangent + std::sin(a) * (std::cos(b) * side + std::sin(b) * front);
      const Light light = make_directional_light(-to_light);
      const Picture picture = render(scene, {&light, 1}, 16);
      EXPECT_EQ(darker_pixels(picture), 0)
          << from_tangent_deg << " degrees to the strand, turned " << turn << " / 8";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Radii, StrandSelfShadow, testing::Values(0.001f, 0.01f, 0.05f));

TEST(StrandShadow, FallsOnTheNextStrandAndOnTheGround) {
  Scene scene = make_plane_scene(5, vec3(0.5f), 64, 64);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_strand({0, -9, 0.5f}, {0, 9, 0.5f}, 0.02f, 4, hair));
  add_shape(scene, make_strand({0, -9, 0.6f}, {0, 9, 0.6f}, 0.02f, 4, hair));
  const Tracer tracer(scene);
  TracedVisibility traced(tracer);
  traced.prepare(make_directional_light({0, 0, -1}));
  const float weight[] = {1, 1, 1, 1};
  const float x[] = {0, 0, 0, 0.03f};
  const float y[] = {0.1f, 0.1f, 0.1f, 0.1f};
  const float z[] = {0, 0.5f, 0.6f, 0};
  const float bias[] = {0.04f, 0.04f, 0.04f, 0.04f};
  Receivers receivers;
  receivers.count = 4;
  receivers.weight = weight;
  receivers.position[0] = x;
  receivers.position[1] = y;
  receivers.position[2] = z;
  receivers.bias = bias;
  float visibility[4];
  traced.visibility(receivers, visibility);
  EXPECT_EQ(visibility[0], 0) << "ground below both";
  EXPECT_EQ(visibility[1], 0) << "lower strand";
  EXPECT_EQ(visibility[2], 1) << "upper strand";
  EXPECT_EQ(visibility[3], 1) << "ground beside them";
}

}  // namespace
}  // namespace relume

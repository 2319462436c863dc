#include <gtest/gtest.h>

#include "core/relight/relight.h"
#include "tests/support/scenes.h"

// Pictures with known answers, without shadows.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

constexpr double pi_double = 3.14159265358979323846;
constexpr int spp = 4;
constexpr uint64_t seed = 11;

/// Where the samples of a pixel meet the plane z = 0, from the sampler's own film positions.
std::vector<dvec3> plane_points(const Scene& scene, int x, int y) {
  const CameraRays rays(scene.camera, scene.width, scene.height);
  std::vector<vec2> positions;
  sample_pixel(make_pixel_strata(spp), seed,
               static_cast<uint64_t>(y) * static_cast<uint64_t>(scene.width) + x, positions);
  std::vector<dvec3> points;
  for (const vec2 offset : positions) {
    const dvec3 direction(rays.direction(vec2(x, y) + offset));
    const dvec3 eye(rays.eye());
    points.push_back(eye - direction * (eye.z / direction.z));
  }
  return points;
}

double spot_weight(const Light& light, dvec3 wi) {
  const double outer = std::cos(light.outer_angle_deg * pi_double / 180);
  const double inner = std::cos(light.inner_angle_deg * pi_double / 180);
  const double cosine = glm::dot(-wi, glm::normalize(dvec3(light.direction)));
  const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// Radiance of a Lambert plane z = 0 of albedo 1 at `p`, per unit weight.
double plane_radiance(const Light& light, dvec3 p) {
  if (light.type == LightType::directional) {
    return std::max(0.0, -glm::normalize(dvec3(light.direction)).z) / pi_double;
  }
  const dvec3 to_light = dvec3(light.position) - p;
  const double d = glm::length(to_light);
  double value = std::max(0.0, to_light.z / d) / pi_double / (light.falloff ? d * d : 1);
  if (light.type == LightType::spot) value *= spot_weight(light, to_light / d);
  return value;
}

class LambertPlane : public testing::TestWithParam<Light> {};

TEST_P(LambertPlane, ShowsAlbedoOverPiTimesIrradiance) {
  const vec3 albedo(0.8f, 0.4f, 0.1f);
  const Scene scene = make_plane_scene(10, albedo, 40, 30);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, spp, seed);
  const Light light = GetParam();
  const Image frame = render_frame(cache, {&light, 1});
  double brightest = 0;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      double expected = 0;
      for (const dvec3 p : plane_points(scene, x, y)) expected += plane_radiance(light, p) / spp;
      brightest = std::max(brightest, expected);
      for (size_t c = 0; c < 3; ++c) {
        const double value = expected * albedo[c] * light.weight()[c];
        EXPECT_NEAR(frame.at(x, y)[c], value, 1e-4 * value + 2e-6) << x << " " << y;
      }
    }
  }
  EXPECT_GT(brightest, 0.01);
}

Light coloured(Light light, vec3 color) {
  light.color = color;
  return light;
}

INSTANTIATE_TEST_SUITE_P(Lights, LambertPlane,
                         testing::Values(make_point_light({0.5f, 0.3f, 1.5f}, 3),
                                         make_point_light({0, 0, 0.05f}, 2),
                                         make_point_light({0.5f, 0.3f, 1.5f}, 3, false),
                                         coloured(make_point_light({-1, 0, 2}, 2), {1, 0.5f, 0}),
                                         make_spot_light({0, 1, 2}, {0, -1, -2}, 10, 25),
                                         make_spot_light({0, 1, 2}, {0, -1, -2}, 10, 25, false),
                                         make_spot_light({0.2f, 0, 1}, {0, 0, -1}, 0, 90),
                                         make_directional_light({1, 1, -1}, 2),
                                         make_directional_light({0, 0, -1})));

TEST(LambertPlane, IsBlackFromBehind) {
  const Scene scene = make_plane_scene(10, vec3(1), 8, 8);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 1);
  for (const Light& light : {make_point_light({0, 0, -1}), make_directional_light({0, 0, 1})}) {
    EXPECT_EQ(max_difference(render_frame(cache, {&light, 1}), Image(8, 8)), 0);
  }
}

TEST(Background, StaysBlackAndUncovered) {
  const Scene scene = make_plane_scene(0.5f, vec3(1), 32, 32);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 16);
  const Light light = make_directional_light({0, 0, -1}, 3);
  const Image frame = render_frame(cache, {&light, 1});
  const std::vector<float> coverage = cache.coverage();
  double covered = 0;
  for (size_t pixel = 0; pixel < coverage.size(); ++pixel) {
    EXPECT_NEAR(frame.rgb(pixel).x, coverage[pixel] * 3 / pi, 3e-3);
    covered += coverage[pixel];
  }
  const double side = 1 / (4 * std::tan(20 * pi_double / 180) * 2 / 32);
  EXPECT_NEAR(covered, side * side, 2);
  EXPECT_EQ(frame.rgb(0), vec3(0));
}

TEST(PhongPlane, ShowsItsHighlightWhereTheMirrorRayGoes) {
  Scene scene = make_plane_scene(10, vec3(0), 61, 61);
  scene.materials[0] = {};
  scene.materials.clear();
  add_material(scene, "phong",
               {{"diffuse", vec3(0)}, {"specular", vec3(1)}, {"exponent", vec3(40)}});
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, spp, seed);
  // The eye at (0, 0, 4) and a light at (1, 0, 4), both 4 above: the highlight is at x = 0.5, and a
  // light without falloff shows (e + 2) / (2 pi) cos there.
  const Light light = make_point_light({1, 0, 4}, 1, false);
  const Image frame = render_frame(cache, {&light, 1});
  float best = 0;
  ivec2 place(0);
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) {
      if (frame.at(x, y)[0] <= best) continue;
      best = frame.at(x, y)[0];
      place = {x, y};
    }
  }
  const CameraRays rays(scene.camera, 61, 61);
  const vec2 expected = rays.project({0.5f, 0, 0}).film_px;
  EXPECT_NEAR(static_cast<float>(place.x) + 0.5f, expected.x, 2);
  EXPECT_NEAR(static_cast<float>(place.y) + 0.5f, expected.y, 2);
  const double cosine = 4 / std::sqrt(16.25);
  EXPECT_NEAR(best, 42 / (2 * pi_double) * cosine, 0.01 * best);
}

struct Similarity {
  float scale;
  vec3 offset;
};

class MovedScene : public testing::TestWithParam<Similarity> {};

TEST_P(MovedScene, GivesTheSamePicture) {
  Scene scene = make_plane_scene(1, vec3(0.5f), 48, 48);
  add_material(scene, "phong", {{"exponent", vec3(20)}});
  add_material(scene, "kajiya-kay");
  add_shape(scene, make_sphere({0, 0, 0.4f}, 0.4f, 24, 1));
  add_shape(scene, make_strand({-0.8f, -0.8f, 0.2f}, {0.8f, 0.6f, 0.9f}, 0.05f, 6, 2));
  scene.lights = {make_point_light({1, 1, 2}, 4), make_point_light({-1, 0, 2}, 1, false),
                  make_spot_light({0, -2, 2}, {0, 2, -2}, 10, 40),
                  make_directional_light({0, -1, -1})};
  const auto [scale, offset] = GetParam();
  const Scene moved = move_scene(scene, scale, offset);
  const Tracer tracer(scene);
  const Tracer moved_tracer(moved);
  const Image expected = render_frame(make_full_cache(scene, tracer, 4), scene.lights);
  const Image frame = render_frame(make_full_cache(moved, moved_tracer, 4), moved.lights);
  int different = 0;
  for (size_t i = 0; i < expected.pixels.size(); ++i) {
    ASSERT_TRUE(is_finite(frame.pixels[i]));
    if (std::abs(frame.pixels[i] - expected.pixels[i]) > 1e-3f + 1e-3f * expected.pixels[i]) {
      ++different;
    }
  }
  // Samples at outlines and facet edges may round to the other side.
  const bool far_away = offset != vec3(0);
  EXPECT_LE(different, far_away ? 400 : 60);
}

INSTANTIATE_TEST_SUITE_P(Similarities, MovedScene,
                         testing::Values(Similarity{1e-6f, vec3(0)}, Similarity{1e-3f, vec3(0)},
                                         Similarity{1e3f, vec3(0)}, Similarity{1e6f, vec3(0)},
                                         Similarity{1, vec3(100, -50, 20)},
                                         Similarity{1, vec3(1e4f, 0, 0)}));

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include "core/math/color.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/session/light_color.h"
#include "viewer/session/light_placement.h"
#include "viewer/session/spot_cone.h"

namespace relume {
namespace {

TEST(LightColor, TemperatureComesBackFromItsColor) {
  for (const float kelvin : {2000.0f, 2700.0f, 4000.0f, 5600.0f, 6500.0f, 10000.0f, 14000.0f}) {
    const vec3 color = color_of_temperature(kelvin, vec3(0.3f, 2, 1));
    EXPECT_NEAR(luminance(color), luminance(vec3(0.3f, 2, 1)), 1e-5);
    const auto back = temperature_of_color(color);
    ASSERT_TRUE(back.has_value()) << kelvin;
    EXPECT_NEAR(*back / kelvin, 1, 2e-3);
  }
  const vec3 candle = color_of_temperature(1800, vec3(1));
  EXPECT_GT(candle.x, 3 * candle.y * 0.6f);
  EXPECT_GT(candle.y, candle.z);
  const vec3 sky = color_of_temperature(15000, vec3(1));
  EXPECT_GT(sky.z, sky.x);
}

TEST(LightColor, NearDaylightWhiteIsNear6500) {
  const auto kelvin = temperature_of_color(vec3(1));
  ASSERT_TRUE(kelvin.has_value());
  EXPECT_NEAR(*kelvin, 6504, 30) << "D65 has a correlated colour temperature of 6504 K";
}

TEST(LightColor, BlackAndVividColorsHaveNoTemperature) {
  EXPECT_FALSE(temperature_of_color(vec3(0)).has_value());
  EXPECT_FALSE(temperature_of_color(vec3(0, 1, 0)).has_value());
  EXPECT_FALSE(temperature_of_color(vec3(1, 0, 1)).has_value());
}

/// A plane y = 0 seen from above.
SurfacePoint floor_point(vec3 position = vec3(0)) {
  SurfacePoint surface{};
  surface.position = position;
  surface.geometric_normal = surface.shading_normal = vec3(0, 1, 0);
  return surface;
}

Bounds unit_bounds() {
  Bounds bounds;
  bounds.extend(vec3(-1));
  bounds.extend(vec3(1));
  return bounds;
}

vec3 direction_to(const Light& light, vec3 p) {
  return glm::normalize(light.position - p);
}

TEST(LightPlacement, HighlightReflectsTheEyeAndKeepsTheDistance) {
  Light light;
  light.type = LightType::spot;
  light.position = vec3(0.5f, 3, 1);
  const SurfacePoint surface = floor_point(vec3(0.2f, 0, 0.1f));
  const float distance = glm::distance(light.position, surface.position);
  const vec3 eye(2, 2, 0);
  place_light(light, PlaceTool::highlight, surface, eye, unit_bounds());
  const vec3 wi = direction_to(light, surface.position);
  const vec3 wo = glm::normalize(eye - surface.position);
  EXPECT_NEAR(glm::distance(glm::normalize(wi + wo), vec3(0, 1, 0)), 0, 1e-5);
  EXPECT_NEAR(glm::distance(light.position, surface.position), distance, 1e-5);
  EXPECT_NEAR(glm::distance(glm::normalize(light.direction), -wi), 0, 1e-5);
}

TEST(LightPlacement, DiffusePeakIsOverTheSurface) {
  Light light;
  light.type = LightType::directional;
  light.direction = vec3(1, -1, 0);
  place_light(light, PlaceTool::diffuse, floor_point(), vec3(0, 5, 5), unit_bounds());
  EXPECT_NEAR(glm::distance(light.direction, vec3(0, -1, 0)), 0, 1e-6);
}

TEST(LightPlacement, RimGrazesFromBehind) {
  Light light;
  light.position = vec3(0, 2, 2);
  const vec3 eye(0, 1, 5);
  place_light(light, PlaceTool::rim, floor_point(), eye, unit_bounds());
  const vec3 wi = direction_to(light, vec3(0));
  EXPECT_NEAR(wi.y, std::sin(radians_from_degrees(15)), 1e-5);
  EXPECT_LT(wi.z, -0.9f) << "away from the eye";
}

TEST(LightPlacement, OnStrandsTheNearestPeakOfTheConeIsTaken) {
  SurfacePoint strand{};
  strand.tangent = vec3(1, 0, 0);
  strand.shading_normal = vec3(0, 0, 1);
  const vec3 eye(1, 0, 2);
  Light light;
  light.position = vec3(3, 4, 0);
  place_light(light, PlaceTool::highlight, strand, eye, unit_bounds());
  vec3 wi = direction_to(light, vec3(0));
  EXPECT_NEAR(wi.x, -glm::normalize(eye).x, 1e-5) << "Kajiya-Kay: the mirrored cone";
  EXPECT_NEAR(wi.z, 0, 1e-5) << "the light stays on its side";
  EXPECT_GT(wi.y, 0);
  place_light(light, PlaceTool::diffuse, strand, eye, unit_bounds());
  wi = direction_to(light, vec3(0));
  EXPECT_NEAR(glm::distance(wi, vec3(0, 1, 0)), 0, 1e-5);
}

TEST(LightPlacement, ADraggedShadowFallsWhereItIsPut) {
  const Scene scene = load_scene("spheres", shader_table());
  const Tracer tracer(scene);
  const CameraRays rays(scene.camera, scene.width, scene.height);
  int dragged = 0;
  for (const Light& start : scene.lights) {
    for (int y = 4; y < scene.height; y += 29) {
      for (int x = 4; x < scene.width; x += 29) {
        const auto from = find_surface(tracer, rays, vec2(x, y));
        const auto to = find_surface(tracer, rays, vec2(x + 6, y + 2));
        if (!from || !to) continue;
        Light light = start;
        const auto grip = grab_shadow(tracer, *from, light);
        if (!grip) continue;
        drag_shadow(light, *grip, to->position);
        if (glm::dot(to->shading_normal, grip->occluder - to->position) <= 0) continue;
        EXPECT_TRUE(grab_shadow(tracer, *to, light).has_value()) << x << ", " << y;
        ++dragged;
      }
    }
  }
  EXPECT_GT(dragged, 10);
}

TEST(SpotCone, AnAngleDrawnIsTheAngleRead) {
  Light light;
  light.type = LightType::spot;
  light.position = vec3(0, 3, 0);
  light.direction = vec3(0, -2, 0);
  light.outer_angle_deg = 25;
  const SpotCone cone = make_spot_cone(light, 3, unit_bounds());
  for (const float angle : {5.0f, 25.0f, 60.0f, 85.0f}) {
    for (const float turn : {0.0f, 1.0f, 4.0f}) {
      EXPECT_NEAR(cone_angle_at(cone, cone_point(cone, angle, turn)), angle, 0.01f);
    }
  }
  EXPECT_NEAR(glm::distance(cone_point(cone, 25, 2), vec3(0, 3 - cone.distance, 0)),
              cone.distance * std::tan(radians_from_degrees(25)), 1e-4);
}

}  // namespace
}  // namespace relume

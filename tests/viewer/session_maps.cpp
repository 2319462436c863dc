#include <gtest/gtest.h>

#include "core/relight/pixel_visibility.h"
#include "core/relight/relight.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "shadow/shadow.h"
#include "tests/viewer/lamp_scene.h"
#include "viewer/session/false_color.h"
#include "viewer/session/picture_histogram.h"
#include "viewer/session/pixel_maps.h"
#include "viewer/session/prepare.h"
#include "viewer/session/visibility_source.h"

namespace relume {
namespace {

/// A built-in scene, small, in one of the formats.
struct Small {
  explicit Small(const char* name, CacheFormat format = CacheFormat::exact)
      : scene(load_scene(name, shader_table())), tracer(scene) {
    PrepareParams params;
    params.spp = 9;
    params.reduction.records = 3;
    params.width = 64;
    params.height = 48;
    params.format = format;
    cache.emplace(prepare_in_memory(scene, tracer, params, {}));
  }
  Scene scene;
  Tracer tracer;
  std::optional<RelightCache> cache;
};

class PixelReports : public testing::TestWithParam<const char*> {};

TEST_P(PixelReports, LightsAndRecordsAddUpToTheFrame) {
  for (const CacheFormat format : {CacheFormat::exact, CacheFormat::standard}) {
    const Small small(GetParam(), format);
    std::vector<Light> lights = small.scene.lights;
    lights.push_back(lights[0]);
    lights.back().mute = true;
    for (const bool shadowed : {false, true}) {
      const auto rays = make_shadow(ShadowMethod::ray, small.tracer, *small.cache);
      RelightState state = make_relight_state(*small.cache);
      relight(state, lights, shadowed ? rays.get() : nullptr);
      const Tracer* tracer = shadowed ? &small.tracer : nullptr;
      for (int y = 0; y < 48; y += 5) {
        for (int x = 0; x < 64; x += 3) {
          const PixelReport report = inspect_pixel(*small.cache, tracer, lights, x, y);
          vec3 from_lights(0);
          for (const vec3 value : report.light_values) from_lights += value;
          vec3 from_records(0);
          for (const InspectedRecord& record : report.records) from_records += record.radiance;
          const vec3 frame = state.frame.rgb(static_cast<size_t>(y) * 64 + x);
          const float tolerance = 2e-4f * max_component(frame) + 1e-6f;
          EXPECT_NEAR(glm::distance(from_lights, frame), 0, tolerance) << x << ", " << y;
          EXPECT_NEAR(glm::distance(from_records, frame), 0, tolerance) << x << ", " << y;
          EXPECT_EQ(report.light_values.back(), vec3(0)) << "muted";
          EXPECT_EQ(report.records.empty(), report.coverage == 0);
        }
      }
    }
  }
}

TEST(PixelReport, EmissionIsWhatLightsDoNotAdd) {
  const Scene scene = parse_scene(test::lamp_scene, "lamp.json", shader_table());
  const Tracer tracer(scene);
  PrepareParams params;
  params.spp = 9;
  params.reduction.records = 3;
  const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
  RelightState state = make_relight_state(cache);
  relight(state, scene.lights, nullptr);
  float brightest = 0;
  for (int y = 0; y < 40; y += 3) {
    for (int x = 0; x < 48; x += 3) {
      const PixelReport report = inspect_pixel(cache, nullptr, scene.lights, x, y);
      vec3 sum = report.emission;
      for (const vec3 value : report.light_values) sum += value;
      const vec3 frame = state.frame.rgb(static_cast<size_t>(y) * 48 + x);
      EXPECT_NEAR(glm::distance(sum, frame), 0, 2e-4f * max_component(frame) + 1e-6f);
      brightest = std::max(brightest, report.emission.x);
    }
  }
  EXPECT_EQ(brightest, 2);
}

INSTANTIATE_TEST_SUITE_P(Scenes, PixelReports, testing::Values("spheres", "hair", "plants"));

TEST(PixelMaps, NormalsAreUnitAndTypesAreTheRecords) {
  const Small small("plants");
  const Image normals = normal_map(*small.cache);
  const Image types = type_map(*small.cache);
  const std::vector<float> coverage = small.cache->coverage();
  for (size_t pixel = 0; pixel < normals.pixel_count(); ++pixel) {
    const bool is_covered = coverage[pixel] > 0;
    EXPECT_EQ(types.rgb(pixel) != vec3(0), is_covered);
    if (!is_covered) {
      EXPECT_EQ(normals.rgb(pixel), vec3(0));
      continue;
    }
    EXPECT_NEAR(glm::length(2.0f * normals.rgb(pixel) - 1.0f), 1, 1e-4);
  }
}

TEST(PixelMaps, VisibilityIsThatOfTheFirstLight) {
  const Small small("spheres");
  const auto source = make_visibility_source(*small.cache, small.tracer);
  const auto rays = make_shadow(ShadowMethod::ray, small.tracer, *small.cache);
  const std::atomic<bool> cancelled{false};
  for (const Light& light : small.scene.lights) {
    RelitFrame frame;
    source->render({.lights = {light}, .shadows = ShadowMethod::none}, cancelled, frame);
    rays->prepare(light);
    EXPECT_EQ(frame.image.pixels, pixel_visibility(*small.cache, *rays));
  }
}

TEST(FalseColor, TellsStopsApart) {
  EXPECT_EQ(false_color(-7), vec3(0));
  EXPECT_EQ(false_color(-std::numeric_limits<float>::infinity()), vec3(0));
  EXPECT_EQ(false_color(std::nanf("")), vec3(0));
  EXPECT_EQ(false_color(6), vec3(1));
  for (int stop = -6; stop < 5; ++stop) {
    const auto low = static_cast<float>(stop);
    EXPECT_EQ(false_color(low), false_color(low + 0.99f));
    EXPECT_NE(false_color(low), false_color(low + 1));
  }
  Image image(2, 1);
  for (float& value : image.pixels) value = middle_grey * 4.1f;
  std::vector<uint8_t> rgba(8);
  apply_false_color(image, -2, rgba);
  EXPECT_EQ(rgba[0], std::lround(255 * false_color(0.02f).x));
  EXPECT_EQ(rgba[7], 255);
}

TEST(Histogram, CountsPixels) {
  const std::vector<uint8_t> rgba = {0,  0,  0,  255, 255, 10, 10, 255,
                                     10, 10, 11, 255, 10,  0,  0,  255};
  const PictureHistogram histogram = make_histogram(rgba);
  EXPECT_EQ(histogram.counts[0][10], 2u);
  EXPECT_EQ(histogram.counts[2][11], 1u);
  EXPECT_EQ(histogram.largest, 2u);
  EXPECT_EQ(histogram.clipped_share, 0.25);
  EXPECT_EQ(histogram.black_share, 0.25);
  EXPECT_EQ(make_histogram({}).clipped_share, 0);
}

}  // namespace
}  // namespace relume

// Light that materials send out by themselves: part of every frame, whatever the lights do.

#include <gtest/gtest.h>

#include <limits>

#include "core/relight/emission.h"
#include "core/relight/relight.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

constexpr vec3 glow(3, 0.5f, 0.25f);
constexpr int size = 36;  // pixels, not whole tiles

/// A black quad that glows before a grey one, neither of which fills the view.
Scene make_lamp(vec3 emission = glow) {
  Scene scene = make_empty_scene(make_camera({0, 0, 4}, {0, 0, 0}, 40), size, size);
  const uint32_t lamp = add_material(scene, "lambert", {{"diffuse", vec3(0)}});
  const uint32_t grey = add_material(scene, "lambert", {{"diffuse", vec3(0.5f)}});
  scene.materials[lamp].emission = emission;
  add_shape(scene, make_quad({0.31f, 0.2f, 0}, {0.5f, 0.1f, 0}, {-0.1f, 0.6f, 0}, lamp));
  add_shape(scene, make_quad({-0.4f, -0.3f, -0.5f}, {0.9f, 0, 0}, {0, 0.9f, 0}, grey));
  return scene;
}

/// The view's samples as a cache.
RelightCache make_cache(const Scene& scene, CacheFormat format = CacheFormat::exact) {
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, size, size, 16, 1);
  CacheWriter writer;
  for (int i = 0; i < tile_count(view); ++i) {
    writer.add(pack_tile(sample_tile(view, i), view.types.types, {format, scene.camera}));
  }
  CacheInfo info = make_cache_info(scene, view.types, 16, 1);
  writer.finish(info);
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "lamp");
}

/// Emission times the fraction of each pixel's samples that meet the glowing material.
Image expected_emission(const Scene& scene) {
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, size, size, 16, 1);
  Image image(size, size);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      std::vector<vec2> positions;
      sample_pixel(view.strata, view.seed, static_cast<uint64_t>(y) * size + x, positions);
      int hits = 0;
      for (const vec2 position : positions) {
        const auto point = tracer.intersect(
            {.origin = view.rays.eye(), .direction = view.rays.direction(vec2(x, y) + position)});
        if (point && max_component(scene.materials[point->material].emission) > 0) ++hits;
      }
      const vec3 value = scene.materials[0].emission * (static_cast<float>(hits) / 16.0f);
      std::copy_n(&value.x, 3, image.at(x, y));
    }
  }
  return image;
}

TEST(Emission, WithoutLightsThePictureIsEmissionTimesCoverage) {
  const Scene scene = make_lamp();
  const Image expected = expected_emission(scene);
  float brightest = 0;
  for (const float value : expected.pixels) brightest = std::max(brightest, value);
  ASSERT_FLOAT_EQ(brightest, glow.x) << "some pixel is all lamp";
  for (const CacheFormat format :
       {CacheFormat::exact, CacheFormat::standard, CacheFormat::compact}) {
    const RelightCache cache = make_cache(scene, format);
    ASSERT_TRUE(cache.info().has_emission);
    EXPECT_LT(max_difference(render_frame(cache, {}), expected), 1e-5f);
    EXPECT_LT(max_difference(emission_image(cache), expected), 1e-5f);
  }
}

TEST(Emission, IsAddedToWhatLightsGive) {
  const std::vector<Light> lights{make_point_light({0, 1, 3}, 5),
                                  make_directional_light({0, -1, -1}, 0.5f)};
  const RelightCache dark = make_cache(make_lamp(vec3(0)));
  const RelightCache lit = make_cache(make_lamp());
  EXPECT_FALSE(dark.info().has_emission);
  Image sum = render_frame(dark, lights);
  const Image emission = emission_image(lit);
  for (size_t i = 0; i < sum.pixels.size(); ++i) sum.pixels[i] += emission.pixels[i];
  EXPECT_EQ(render_frame(lit, lights).pixels, sum.pixels);
}

TEST(Emission, StaysTheSameFromFrameToFrame) {
  const RelightCache cache = make_cache(make_lamp());
  std::vector<Light> lights{make_point_light({0, 1, 3}, 5), make_point_light({1, 1, 3}, 2),
                            make_point_light({-1, 1, 3}, 1)};
  RelightState state = make_relight_state(cache);
  for (const bool dragging : {false, true, true, true}) {
    lights[0].position.x += 0.5f;
    relight(state, lights, nullptr, {.pixels = PixelShare::quarter});
    relight(state, lights, nullptr, {.dragging = dragging});
  }
  for (Light& light : lights) light.mute = true;
  relight(state, lights, nullptr);
  EXPECT_EQ(state.frame.pixels, emission_image(cache).pixels);
}

TEST(Emission, TexturesMultiplyIt) {
  Scene scene = make_lamp();
  // Left half black, right half white.
  scene.textures.push_back({"halves", 2, 1, true, {0, 0, 0, 255, 255, 255, 255, 255}});
  scene.materials[0].emission_texture = 0;
  const RelightCache cache = make_cache(scene);
  scene.materials[0].emission_texture = -1;
  const RelightCache whole = make_cache(scene);
  const auto total = [](const RelightCache& of) {
    double sum = 0;
    for (const float value : of.emission()) sum += value;
    return sum;
  };
  EXPECT_NEAR(total(cache) / total(whole), 0.5, 0.05);
}

TEST(Emission, LargestOnesStayFinite) {
  Scene scene = make_lamp(vec3(1e20f));
  validate_scene(scene);
  const RelightCache cache = make_cache(scene);
  for (const float value : render_frame(cache, {}).pixels) ASSERT_TRUE(is_finite(value));
  for (const float wrong : {-1.0f, 2e20f, std::numeric_limits<float>::quiet_NaN()}) {
    scene.materials[0].emission.y = wrong;
    EXPECT_ERROR(validate_scene(scene), ErrorKind::input, "/emission");
  }
  scene.materials[0].emission = vec3(1);
  scene.materials[0].emission_texture = 0;
  EXPECT_ERROR(validate_scene(scene), ErrorKind::input, "missing emission texture");
}

TEST(Emission, CachesWithForgedOnesAreRefused) {
  const std::vector<SampleType> types = all_sample_types();
  for (const float forged : {0.5f, -1.0f, 1e30f, std::numeric_limits<float>::infinity(),
                             std::numeric_limits<float>::quiet_NaN()}) {
    SampleTile tile = make_random_tile(types, 5, 3, 2, 1);
    tile.emission.assign(15, vec3(1));
    tile.emission[14].z = forged;
    CacheWriter writer;
    writer.add(pack_tile(tile, types));
    writer.finish(make_tile_info(tile, types, {0, 0, 5}));
    const auto open = [&] {
      return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "evil");
    };
    if (forged == 0.5f) {
      EXPECT_EQ(open().emission().back(), forged);
    } else {
      EXPECT_ERROR(open(), ErrorKind::input, "an emission is not valid");
    }
  }
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <tuple>

#include "core/math/color.h"
#include "core/samples/sample_scene.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene builders

TEST(SampleType, LaysFieldsOutInOrder) {
  const Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 4, 4);
  const SampleType type = make_sample_type(*scene.shaders[1]);
  EXPECT_EQ(type.name, "phong");
  EXPECT_EQ(type.offsets, (std::vector<int>{0, 3, 4, 7, 10, 13}));
  EXPECT_EQ(type.width, 14);
  EXPECT_EQ(type.field(position_field).name, "position");
  EXPECT_EQ(type.field(bias_field).name, "bias");
}

TEST(SampleTypes, AreThoseThatTheMaterialsUse) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 4, 4);
  add_material(scene, "phong");
  add_material(scene, "lambert");
  add_material(scene, "phong", {{"exponent", vec3(9)}});
  const SampleTypes types = make_sample_types(scene);
  ASSERT_EQ(types.types.size(), 2u);
  EXPECT_EQ(types.types[0].name, "phong");
  EXPECT_EQ(types.types[1].name, "lambert");
  EXPECT_EQ(types.type_of_material, (std::vector<uint16_t>{0, 1, 0}));
}

TEST(SampleTypes, MergeChoicesMakeTypesOfTheirOwn) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 4, 4);
  for (int i = 0; i < 4; ++i) add_material(scene, "phong");
  scene.materials[1].merges = {{"diffuse", Merge::representative}};
  scene.materials[2].merges = {{"diffuse", Merge::average}};  // the default, spelled out
  scene.materials[3].merges = {{"diffuse", Merge::representative},
                               {"normal", Merge::representative}};
  const SampleTypes types = make_sample_types(scene);
  ASSERT_EQ(types.types.size(), 3u);
  EXPECT_EQ(types.types[0].name, "phong");
  EXPECT_EQ(types.types[1].name, "phong#2");
  EXPECT_EQ(types.types[2].name, "phong#3");
  EXPECT_EQ(types.types[1].merges[3], Merge::representative);
  EXPECT_EQ(types.type_of_material, (std::vector<uint16_t>{0, 1, 0, 2}));
}

/// Left half of the view: a Phong quad; right half: background.
Scene make_half_scene() {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 20, 18);
  const uint32_t material =
      add_material(scene, "phong", {{"diffuse", {0.25f, 0.5f, 1}}, {"exponent", vec3(7)}});
  add_shape(scene, make_quad({-50, 0, 0}, {50, 0, 0}, {0, 50, 0}, material));
  return scene;
}

TEST(SampleTile, HoldsEverySampleThatHitWithItsFields) {
  const Scene scene = make_half_scene();
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 20, 18, 9, 1);
  ASSERT_EQ(tile_count(view), 4);
  size_t samples = 0;
  for (int index = 0; index < 4; ++index) {
    const SampleTile tile = sample_tile(view, index);
    EXPECT_EQ(tile.x0, index % 2 * 16);
    EXPECT_EQ(tile.y0, index / 2 * 16);
    EXPECT_EQ(tile.width, index % 2 == 0 ? 16 : 4);
    EXPECT_EQ(tile.height, index / 2 == 0 ? 16 : 2);
    ASSERT_EQ(tile.types.size(), 1u);
    const TypedRows& rows = tile.types[0];
    ASSERT_EQ(rows.first.size(), static_cast<size_t>(tile.pixel_count()) + 1);
    ASSERT_EQ(rows.values.size(), rows.rows() * 14);
    EXPECT_EQ(rows.first.back(), rows.rows());
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      const int x = tile.x0 + pixel % tile.width;
      const uint32_t count = rows.first[pixel + 1] - rows.first[pixel];
      EXPECT_EQ(count, x < 10 ? 9u : 0u) << x;
    }
    for (size_t row = 0; row < rows.rows(); ++row, ++samples) {
      const float* v = &rows.values[row * 14];
      EXPECT_FLOAT_EQ(rows.weights[row], 1.0f / 9);
      EXPECT_LT(v[0], 0);
      EXPECT_NEAR(v[2], 0, 1e-5);
      EXPECT_GT(v[3], 0);
      EXPECT_EQ(vec3(v[4], v[5], v[6]), vec3(0, 0, 1));
      EXPECT_EQ(vec3(v[7], v[8], v[9]), vec3(0.25f, 0.5f, 1));
      EXPECT_EQ(vec3(v[10], v[11], v[12]), vec3(0.05f)) << "the shader's initial value";
      EXPECT_EQ(v[13], 7);
    }
  }
  EXPECT_EQ(samples, 10u * 18 * 9);
}

TEST(SampleTile, TakesExponentsThatKernelsDoNotResolveForZero) {
  for (const float exponent : {1e-45f, 1e-31f, 1e-29f}) {
    Scene scene = make_half_scene();
    scene.materials[0].parameters = {{"exponent", vec3(exponent), -1}};
    const Tracer tracer(scene);
    const TypedRows rows = sample_tile(make_view_sampler(scene, tracer, 20, 18, 1, 3), 0).types[0];
    ASSERT_GT(rows.rows(), 0u);
    EXPECT_EQ(rows.values[13], exponent < 1e-30f ? 0 : exponent);
  }
}

TEST(SampleTile, OnePixelIsBitEqualToItsPart) {
  Scene scene = make_empty_scene(make_camera({0.3f, 0.2f, 3}, vec3(0), 40), 21, 19);
  const uint32_t phong = add_material(scene, "phong", {{"diffuse", {0.25f, 0.5f, 1}}});
  const uint32_t hair = add_material(scene, "kajiya-kay", {{"diffuse", vec3(0.8f)}});
  add_shape(scene, make_sphere({0, 0, -0.5f}, 0.6f, 12, phong));
  for (int i = 0; i < 5; ++i) {
    const float x = -0.8f + 0.4f * static_cast<float>(i);
    add_shape(scene, make_strand({x, -0.7f, 0.3f}, {x + 0.2f, 0.8f, 0.3f}, 0.03f, 6, hair));
  }
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 21, 19, 9, 3);
  size_t mixed = 0;
  for (int index = 0; index < tile_count(view); ++index) {
    const SampleTile tile = sample_tile(view, index);
    const TileRectangle place = tile_rectangle(view, index);
    ASSERT_EQ(std::tuple(place.x0, place.y0, place.width, place.height),
              std::tuple(tile.x0, tile.y0, tile.width, tile.height));
    for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
      const int x = tile.x0 + pixel % tile.width;
      const int y = tile.y0 + pixel / tile.width;
      const SampleTile one = sample_one_pixel(view, x, y);
      ASSERT_EQ(std::tuple(one.x0, one.y0, one.width, one.height), std::tuple(x, y, 1, 1));
      ASSERT_EQ(one.types.size(), tile.types.size());
      size_t kinds = 0;
      for (size_t t = 0; t < tile.types.size(); ++t) {
        const TypedRows& rows = tile.types[t];
        const auto part = [&](const std::vector<float>& values, size_t floats) {
          const auto at = [&](int p) {
            return values.begin() + static_cast<std::ptrdiff_t>(rows.first[p] * floats);
          };
          return std::vector<float>(at(pixel), at(pixel + 1));
        };
        const auto width = static_cast<size_t>(view.types.types[t].width);
        ASSERT_EQ(one.types[t].values, part(rows.values, width)) << x << ' ' << y;
        ASSERT_EQ(one.types[t].weights, part(rows.weights, 1)) << x << ' ' << y;
        const auto count = static_cast<uint32_t>(one.types[t].rows());
        ASSERT_EQ(one.types[t].first, (std::vector<uint32_t>{0, count}));
        kinds += count > 0;
      }
      mixed += kinds > 1;
    }
  }
  EXPECT_GT(mixed, 10u) << "pixels with samples of both types";
  EXPECT_DEATH(sample_one_pixel(view, 21, 0), "pixel 21 0");
  EXPECT_DEATH(sample_one_pixel(view, 0, -1), "pixel 0 -1");
}

TEST(SampleTile, PositionsAreWhereTheStrataSay) {
  const Scene scene = make_half_scene();
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 20, 18, 4, 5);
  const SampleTile tile = sample_tile(view, 0);
  for (const int pixel : {0, 5, 100}) {
    std::vector<vec2> positions;
    const int x = pixel % 16;
    const int y = pixel / 16;
    sample_pixel(view.strata, 5, static_cast<uint64_t>(y * 20 + x), positions);
    for (uint32_t i = 0; i < 4; ++i) {
      const float* v = &tile.types[0].values[(tile.types[0].first[pixel] + i) * 14];
      const vec2 film = view.rays.project({v[0], v[1], v[2]}).film_px;
      EXPECT_NEAR(film.x, static_cast<float>(x) + positions[i].x, 1e-3);
      EXPECT_NEAR(film.y, static_cast<float>(y) + positions[i].y, 1e-3);
    }
  }
}

TEST(SampleTile, BakesTexturesAndStrandColours) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 16, 16);
  scene.textures.push_back({"half", 1, 1, true, {188, 188, 0, 255}});
  const uint32_t textured = add_material(scene, "lambert", {{"diffuse", vec3(0.5f)}});
  scene.materials[textured].parameters[0].texture = 0;
  const uint32_t hair = add_material(scene, "kajiya-kay", {{"diffuse", vec3(0.8f)}});
  add_shape(scene, make_quad({-50, 0, 0}, {50, 0, 0}, {0, 50, 0}, textured));
  Curves strand = make_strand({1, -9, 0}, {1, 9, 0}, 0.5f, 1, hair);
  strand.colors = {vec3(0.5f, 0.25f, 0)};
  add_shape(scene, strand);
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 16, 16, 4, 1);
  const SampleTile tile = sample_tile(view, 0);
  ASSERT_GT(tile.types[0].rows(), 0u);
  ASSERT_GT(tile.types[1].rows(), 0u);
  const float half = 0.5f * linear_from_srgb(188.0f / 255);
  for (size_t row = 0; row < tile.types[0].rows(); ++row) {
    const float* v = &tile.types[0].values[row * 10];
    EXPECT_NEAR(v[7], half, 1e-6);
    EXPECT_NEAR(v[8], half, 1e-6);
    EXPECT_EQ(v[9], 0);
  }
  for (size_t row = 0; row < tile.types[1].rows(); ++row) {
    const float* v = &tile.types[1].values[row * 14];
    EXPECT_NEAR(v[7], 0.4, 1e-6);
    EXPECT_NEAR(v[8], 0.2, 1e-6);
    EXPECT_EQ(v[9], 0);
  }
}

TEST(SampleTile, ThinStrandCoversItsShareOfTheView) {
  // A vertical strand 0.2 pixels wide in a random place of each of 64 columns' width: its coverage
  // is a sum of Bernoulli samples whose mean is its projected area.
  Scene scene = make_empty_scene(make_camera({0, 0, 10}, vec3(0), 10), 64, 64);
  const CameraRays rays(scene.camera, 64, 64);
  const float pixel = 10 * rays.footprint_per_depth();
  const float radius = 0.1f * pixel;
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_strand({0.37f * pixel, -9, 0}, {5.21f * pixel, 9, 0}, radius, 8, hair));
  const Tracer tracer(scene);
  const int spp = 16;
  const ViewSampler view = make_view_sampler(scene, tracer, 64, 64, spp, 3);
  double coverage = 0;
  for (int i = 0; i < tile_count(view); ++i) {
    const SampleTile tile = sample_tile(view, i);
    for (const float weight : tile.types[0].weights) coverage += weight;
  }
  // Area in pixels: width across the strand times its length within 64 rows.
  const double slope = (5.21 - 0.37) * pixel / 18;
  const double expected = 0.2 * 64 * std::sqrt(1 + slope * slope);
  // Strata only lower the variance of independent samples: mean times (1 - p) / spp, p = 0.2.
  const double sigma = std::sqrt(expected * 0.8 / spp);
  EXPECT_LT(std::abs(coverage - expected) / sigma, 4.0) << coverage << " expected " << expected;
}

TEST(SampleTile, IsTheSameWhateverTheOrderOfTiles) {
  const Scene scene = make_half_scene();
  const Tracer tracer(scene);
  const ViewSampler view = make_view_sampler(scene, tracer, 20, 18, 7, 1);
  const SampleTile first = sample_tile(view, 2);
  sample_tile(view, 0);
  const SampleTile again = sample_tile(view, 2);
  EXPECT_EQ(first.types[0].values, again.types[0].values);
  EXPECT_EQ(first.types[0].first, again.types[0].first);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "core/base/parallel.h"
#include "core/image/heatmap.h"
#include "core/image/tiny_font.h"
#include "core/math/color.h"

namespace relume {
namespace {

float luminance_of(vec3 encoded) {
  return luminance(
      vec3(linear_from_srgb(encoded.x), linear_from_srgb(encoded.y), linear_from_srgb(encoded.z)));
}

void expect_near(vec3 value, vec3 expected, float tolerance) {
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], tolerance) << "channel " << c;
}

Image ramp_error(int width, int height, float top) {
  Image error(width, height, 1);
  for (size_t i = 0; i < error.pixels.size(); ++i) {
    error.pixels[i] = top * static_cast<float>(i) / static_cast<float>(error.pixels.size() - 1);
  }
  return error;
}

TEST(HeatColor, MatchesInfernoAtKnownPoints) {
  expect_near(heat_color(0.0f), {0.0015f, 0.0005f, 0.0139f}, 0.02f);
  expect_near(heat_color(0.25f), {0.3415f, 0.0623f, 0.4294f}, 0.02f);
  expect_near(heat_color(0.5f), {0.7357f, 0.2159f, 0.3302f}, 0.02f);
  expect_near(heat_color(0.75f), {0.9784f, 0.5579f, 0.0349f}, 0.02f);
  expect_near(heat_color(1.0f), {0.9884f, 0.9984f, 0.6449f}, 0.02f);
}

TEST(HeatColor, LuminanceRises) {
  float previous = -1;
  for (int i = 0; i <= 512; ++i) {
    const float current = luminance_of(heat_color(static_cast<float>(i) / 512));
    ASSERT_GE(current, previous - 1e-6f) << "at " << i << " / 512";
    if (i % 32 == 0 && i > 0) {
      EXPECT_GT(current, luminance_of(heat_color(static_cast<float>(i - 32) / 512)) + 1e-3f);
    }
    previous = current;
  }
}

TEST(HeatColor, ClampsAndMarksNan) {
  EXPECT_EQ(heat_color(-3), heat_color(0));
  EXPECT_EQ(heat_color(7), heat_color(1));
  EXPECT_EQ(heat_color(std::numeric_limits<float>::infinity()), heat_color(1));
  EXPECT_EQ(heat_color(std::numeric_limits<float>::quiet_NaN()), vec3(1, 0, 1));
}

TEST(Heatmap, AutomaticRangeIsARoundNumberAboveTheQuantile) {
  EXPECT_FLOAT_EQ(automatic_range(ramp_error(100, 100, 0.9f)), 1.0f);
  EXPECT_FLOAT_EQ(automatic_range(ramp_error(100, 100, 0.13f)), 0.2f);
  EXPECT_FLOAT_EQ(automatic_range(ramp_error(100, 100, 3e-4f)), 5e-4f);
  EXPECT_FLOAT_EQ(automatic_range(ramp_error(100, 100, 600.0f)), 1000.0f);
}

TEST(Heatmap, AutomaticRangeIgnoresZerosAndOutliers) {
  Image error(100, 100, 1);
  for (size_t i = 0; i < 2000; ++i) error.pixels[i] = 0.015f;
  error.pixels[5000] = 1e6f;
  EXPECT_FLOAT_EQ(automatic_range(error), 0.02f);
  EXPECT_FLOAT_EQ(automatic_range(Image(8, 8, 1)), 1e-9f) << "no error at all";
  error.pixels.assign(error.pixels.size(), std::numeric_limits<float>::max());
  EXPECT_TRUE(is_finite(automatic_range(error)));
}

TEST(Heatmap, MapsTheRangeToTheEndsOfTheScale) {
  Image error(3, 1, 1);
  error.pixels = {0.0f, 0.05f, 0.1f};
  const DisplayImage map = render_heatmap(error, {0.1f, false});
  ASSERT_EQ(map.width, 3);
  ASSERT_EQ(map.height, 1);
  for (size_t i = 0; i < 3; ++i) {
    const vec3 color = heat_color(0.5f * static_cast<float>(i));
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(map.pixels[3 * i + c], 255 * color[c], 0.51);
  }
}

TEST(Heatmap, ScaleBarStandsBelowThePicture) {
  for (const int width : {1, 40, 64, 399, 400, 1280}) {
    const Image error = ramp_error(width, 20, 0.4f);
    const DisplayImage plain = render_heatmap(error, {0, false});
    const DisplayImage barred = render_heatmap(error, {0, true});
    EXPECT_GT(barred.height, plain.height) << "width " << width;
    ASSERT_EQ(barred.pixels.size(), size_t{3} * barred.width * barred.height);
    for (int y = 0; y < 20; ++y) {
      const auto* row = &barred.pixels[size_t{3} * y * barred.width];
      ASSERT_TRUE(std::equal(row, row + 3 * width, &plain.pixels[size_t{3} * y * width]))
          << "width " << width << " row " << y;
    }
    const std::set<uint8_t> levels(barred.pixels.begin() + size_t{3} * 20 * barred.width,
                                   barred.pixels.end());
    EXPECT_GT(levels.size(), 20u) << "the bar shows the whole map, width " << width;
  }
}

TEST(Heatmap, IsEqualForAnyThreadCount) {
  const Image error = ramp_error(300, 200, 1);
  set_thread_count(1);
  const DisplayImage one = render_heatmap(error, {});
  set_thread_count(3);
  const DisplayImage three = render_heatmap(error, {});
  set_thread_count(0);
  EXPECT_EQ(one.pixels, three.pixels);
}

TEST(TinyFont, GlyphsDifferAndStayInTheirBox) {
  std::set<std::set<std::pair<int, int>>> shapes;
  const std::string characters = "0123456789.-+e";
  for (const char character : characters) {
    std::set<std::pair<int, int>> dots;
    draw_tiny_text(std::string(1, character), [&](int x, int y) {
      EXPECT_TRUE(x >= 0 && x < 5 && y >= 0 && y < tiny_font_height) << character;
      dots.insert({x, y});
    });
    EXPECT_FALSE(dots.empty()) << character;
    shapes.insert(dots);
  }
  EXPECT_EQ(shapes.size(), characters.size());
  EXPECT_EQ(tiny_text_width(""), 0);
  EXPECT_EQ(tiny_text_width("1.5"), 17);
}

}  // namespace
}  // namespace relume

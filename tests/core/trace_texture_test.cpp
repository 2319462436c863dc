#include <gtest/gtest.h>

#include "core/math/color.h"
#include "core/trace/texture_lookup.h"

namespace relume {
namespace {

/// Linear texture whose red is 10 x + 100 y (in codes), top row y = 0, alpha = 255 - red.
Texture make_ramp(int width, int height) {
  Texture texture{"ramp", width, height, false, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto code = static_cast<uint8_t>(10 * x + 100 * y);
      texture.texels.insert(texture.texels.end(), {code, 0, 0, static_cast<uint8_t>(255 - code)});
    }
  }
  return texture;
}

/// uv of the centre of texel (x, y), y counted from the top.
vec2 centre(const Texture& texture, int x, int y) {
  return {(static_cast<float>(x) + 0.5f) / static_cast<float>(texture.width),
          1 - (static_cast<float>(y) + 0.5f) / static_cast<float>(texture.height)};
}

TEST(Texture, CentresGiveTheTexelAndRowsRunTopToBottom) {
  const Texture texture = make_ramp(4, 2);
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 4; ++x) {
      const vec4 value = lookup_texture(texture, centre(texture, x, y));
      EXPECT_NEAR(value.x * 255, 10 * x + 100 * y, 1e-3) << x << " " << y;
      EXPECT_NEAR(value.w * 255, 255 - 10 * x - 100 * y, 1e-3) << x << " " << y;
    }
  }
}

TEST(Texture, HalfwayIsTheMean) {
  const Texture texture = make_ramp(4, 2);
  EXPECT_NEAR(lookup_texture(texture, {2.0f / 4, 0.75f}).x * 255, 15, 1e-3);
  EXPECT_NEAR(lookup_texture(texture, {0.5f / 4, 0.5f}).x * 255, 50, 1e-3);
}

TEST(Texture, RepeatsInBothDirections) {
  const Texture texture = make_ramp(4, 2);
  const vec2 uv(0.3f, 0.7f);
  for (const vec2 shift : {vec2(1, 0), vec2(0, 1), vec2(-1, -1), vec2(5, -3)}) {
    EXPECT_NEAR(lookup_texture(texture, uv + shift).x, lookup_texture(texture, uv).x, 1e-5);
  }
  // At the seam the first and the last column mix.
  EXPECT_NEAR(lookup_texture(texture, {0, 0.75f}).x * 255, 15, 1e-3);
  EXPECT_NEAR(lookup_texture(texture, {1, 0.75f}).x * 255, 15, 1e-3);
}

TEST(Texture, OddCoordinatesStayInside) {
  const Texture texture = make_ramp(3, 2);
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float odd : {std::nanf(""), infinity, -infinity, 3e38f, -3e38f, 1e6f, -1e6f,
                          999999.94f, -1e-20f, 1e-45f, -1e-45f, 0x1.fffffep-1f}) {
    for (const vec2 uv : {vec2(odd, 0), vec2(0, odd), vec2(odd, odd), vec2(odd, 0.3f)}) {
      const vec4 value = lookup_texture(texture, uv);
      for (size_t c = 0; c < 4; ++c) {
        EXPECT_GE(value[c], 0) << odd;
        EXPECT_LE(value[c], 1) << odd;
      }
    }
  }
}

TEST(Texture, OneTexelIsConstant) {
  const Texture texture{"one", 1, 1, false, {10, 20, 30, 40}};
  for (const vec2 uv : {vec2(0), vec2(0.2f, 0.9f), vec2(-3.7f, 12.1f)}) {
    const vec4 value = lookup_texture(texture, uv);
    EXPECT_NEAR(value.x * 255, 10, 1e-4);
    EXPECT_NEAR(value.w * 255, 40, 1e-4);
  }
}

TEST(Texture, DecodesSrgbForColourAndNotForAlpha) {
  const Texture texture{"grey", 1, 1, true, {128, 128, 128, 128}};
  const vec4 value = lookup_texture(texture, vec2(0.5f));
  EXPECT_NEAR(value.x, linear_from_srgb(128.0f / 255), 1e-6);
  EXPECT_NEAR(value.w, 128.0f / 255, 1e-6);
}

TEST(Texture, FiltersLinearLight) {
  const Texture texture{"two", 2, 1, true, {0, 0, 0, 255, 255, 255, 255, 255}};
  EXPECT_NEAR(lookup_texture(texture, {0.5f, 0.5f}).x, 0.5f, 1e-5);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/image/view_table.h"
#include "core/math/color.h"

namespace relume {
namespace {

constexpr float lowest = 0x1p-14f;
constexpr float highest = 64;

vec3 random_color(Random& random) {
  vec3 color;
  for (int c = 0; c < 3; ++c) color[c] = std::exp2(random.uniform(-20, 6));
  return color;
}

void for_each_triple(std::span<float> rgb, const std::function<vec3(vec3)>& function) {
  for (size_t i = 0; i < rgb.size(); i += 3) {
    const vec3 color = function(vec3(rgb[i], rgb[i + 1], rgb[i + 2]));
    std::copy_n(&color.x, 3, &rgb[i]);
  }
}

vec3 look_up(const ViewTable& table, vec3 color) {
  table.apply({&color.x, 3});
  return color;
}

/// A display that mixes channels before it rolls highlights off.
vec3 show_smoothly(vec3 c) {
  const vec3 mixed(0.8f * c.x + 0.15f * c.y + 0.05f * c.z, 0.1f * c.x + 0.8f * c.y + 0.1f * c.z,
                   0.05f * c.x + 0.1f * c.y + 0.85f * c.z);
  const vec3 rolled = mixed / (mixed + 0.6f);
  return {srgb_from_linear(rolled.x), srgb_from_linear(rolled.y), srgb_from_linear(rolled.z)};
}

ViewTable make_smooth_table() {
  return ViewTable([](std::span<float> rgb) { for_each_triple(rgb, show_smoothly); });
}

TEST(ViewTable, KeepsALinearTransform) {
  const auto shear = [](vec3 c) {
    return vec3(0.1f * c.x + 0.02f * c.y, 0.1f * c.y - 0.05f * c.z, 0.2f * c.z + 0.01f * c.x);
  };
  const ViewTable table([&](std::span<float> rgb) { for_each_triple(rgb, shear); });
  Random random(1, RandomStream::tests, 0);
  for (int i = 0; i < 20000; ++i) {
    const vec3 color = random_color(random);
    const vec3 expected = shear(color);
    const vec3 found = look_up(table, color);
    for (int c = 0; c < 3; ++c) {
      ASSERT_NEAR(found[c], expected[c], 1e-6f * max_component(color)) << i;
    }
  }
}

TEST(ViewTable, EqualsTheTransformAtCorners) {
  const ViewTable table = make_smooth_table();
  const std::array<float, 6> corners = {0, lowest, 1.25f * lowest, 0.4375f, 1, highest};
  for (const float r : corners) {
    for (const float g : corners) {
      for (const float b : corners) {
        EXPECT_EQ(look_up(table, {r, g, b}), show_smoothly({r, g, b})) << r << " " << g << " " << b;
      }
    }
  }
}

TEST(ViewTable, IsWithinACodeValueOfASmoothTransform) {
  const ViewTable table = make_smooth_table();
  Random random(2, RandomStream::tests, 0);
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const vec3 color = random_color(random);
    const vec3 expected = show_smoothly(color);
    const vec3 found = look_up(table, color);
    for (int c = 0; c < 3; ++c) {
      worst = std::max(worst, 255 * std::abs(double{found[c]} - expected[c]));
    }
  }
  EXPECT_LT(worst, 1);
  EXPECT_GT(worst, 0.01) << "then the test looks at corners only";
  RecordProperty("worst_code_values", std::to_string(worst));
}

TEST(ViewTable, ClampsWhatLiesBeyond) {
  const ViewTable table = make_smooth_table();
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const vec3 edge = look_up(table, {highest, 0.3f, 0});
  for (const float high : {65.0f, 1e30f, infinity}) {
    for (const float low : {-0.0f, -1e-30f, -7.0f, -infinity, nan, 1e-45f}) {
      const vec3 found = look_up(table, {high, 0.3f, low});
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(found[c], edge[c], 1e-6f) << high << " " << low;
    }
  }
}

TEST(ViewTable, StaysFiniteWhateverTheTransformGives) {
  const ViewTable table([](std::span<float> rgb) {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    for (float& value : rgb) {
      value = value > 1 ? std::log(-value) : value == 1 ? infinity : 1 / (value - 1);
    }
  });
  for (const float x : {0.0f, 0.9f, 1.0f, 1.1f, 3.0f, 64.0f}) {
    const vec3 found = look_up(table, vec3(x, 0.5f, 2));
    for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(found[c])) << x;
  }
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/image/display_transform.h"

namespace relume {
namespace {

/// The documented formula in double, before rounding to a byte, in [0, 255].
double exact_display(double linear, const DisplayTransform& transform) {
  double x = linear * std::exp2(double{transform.exposure});
  if (transform.curve == ToneCurve::filmic) {
    x = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
  }
  x = std::clamp(x, 0.0, 1.0);
  return 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
}

/// Values over many octaves, with the corners.
Image ramp_image(int channels) {
  Image image(400, 256, channels);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(image.pixels.size());
    image.pixels[i] = std::exp2(-18.0f + 24.0f * t);
  }
  image.pixels[0] = 0;
  image.pixels[1] = 1;
  return image;
}

class Display : public testing::TestWithParam<DisplayTransform> {};

TEST_P(Display, StaysWithinOneCodeOfTheExactFormula) {
  const Image image = ramp_image(3);
  const DisplayImage display = apply_display(image, GetParam());
  ASSERT_EQ(display.pixels.size(), image.pixels.size());
  double worst = 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const double exact = exact_display(image.pixels[i], GetParam());
    worst = std::max(worst, std::abs(display.pixels[i] - exact));
  }
  EXPECT_LE(worst, 0.6) << "in code values; rounding alone is 0.5";
}

TEST_P(Display, RisesWithTheInput) {
  const Image image = ramp_image(3);
  const DisplayImage display = apply_display(image, GetParam());
  for (size_t i = 3; i < image.pixels.size(); ++i) {
    ASSERT_GE(display.pixels[i], display.pixels[i - 1]) << "value " << image.pixels[i];
  }
}

INSTANTIATE_TEST_SUITE_P(All, Display,
                         testing::Values(DisplayTransform{0, ToneCurve::srgb},
                                         DisplayTransform{2.5f, ToneCurve::srgb},
                                         DisplayTransform{-3, ToneCurve::srgb},
                                         DisplayTransform{0, ToneCurve::filmic},
                                         DisplayTransform{1.3f, ToneCurve::filmic}));

TEST(DisplayTransform, MapsNonFiniteAndNegativeToTheEnds) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image image(2, 2);
  image.pixels = {nan, -nan, infinity, -infinity, -1, -1e-30f, 1e38f, 1, 0, 1e-40f, -0.0f, 0};
  const std::vector<uint8_t> expected = {0, 0, 255, 0, 0, 0, 255, 255, 0, 0, 0, 0};
  EXPECT_EQ(apply_display(image, {}).pixels, expected);
  EXPECT_EQ(apply_display(image, {500, ToneCurve::srgb}).pixels[2], 255) << "overflowing scale";
}

TEST(DisplayTransform, RgbaRepeatsRgbWithOpaqueAlpha) {
  const Image image = ramp_image(5);
  const DisplayTransform transform{0.5f, ToneCurve::filmic};
  const DisplayImage rgb = apply_display(image, transform);
  std::vector<uint8_t> rgba(image.pixel_count() * 4);
  apply_display_rgba(image, transform, rgba);
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    for (size_t c = 0; c < 3; ++c) ASSERT_EQ(rgba[4 * i + c], rgb.pixels[3 * i + c]);
    ASSERT_EQ(rgba[4 * i + 3], 255);
  }
}

TEST(DisplayTransform, IsEqualForAnyThreadCount) {
  const Image image = ramp_image(3);
  set_thread_count(1);
  const DisplayImage one = apply_display(image, {});
  set_thread_count(4);
  const DisplayImage four = apply_display(image, {});
  set_thread_count(0);
  EXPECT_EQ(one.pixels, four.pixels);
}

}  // namespace
}  // namespace relume

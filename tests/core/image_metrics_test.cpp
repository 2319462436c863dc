#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/image/metrics.h"

namespace relume {
namespace {

Image constant_image(int width, int height, vec3 color) {
  Image image(width, height);
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    for (size_t c = 0; c < 3; ++c) image.pixels[3 * i + c] = color[c];
  }
  return image;
}

Image random_image(int width, int height, uint64_t seed) {
  Image image(width, height);
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    Random random(seed, RandomStream::tests, i);
    image.pixels[i] = random.uniform();
  }
  return image;
}

TEST(Metrics, EqualImagesHaveNoError) {
  const Image image = random_image(17, 9, 1);
  const ImageError error = compare_images(image, image);
  EXPECT_EQ(error.error_image, 0);
  EXPECT_EQ(error.error_covered, 0);
  EXPECT_EQ(error.rmse, 0);
  EXPECT_EQ(error.relative_mse, 0);
  EXPECT_EQ(error.max_error, 0);
  EXPECT_EQ(error.pixels, 17u * 9u);
  EXPECT_EQ(error.covered_pixels, 17u * 9u);
}

TEST(Metrics, ConstantOffsetHasClosedForm) {
  const Image reference = constant_image(31, 20, {0.5f, 0.25f, 1.0f});
  const Image image = constant_image(31, 20, {0.75f, 0.25f, 0.5f});
  const ImageError error = compare_images(image, reference);
  const double rms = std::sqrt((0.0625 + 0.25) / 3);
  EXPECT_NEAR(error.error_image, rms, 1e-15);
  EXPECT_NEAR(error.error_covered, rms, 1e-15);
  EXPECT_NEAR(error.rmse, rms, 1e-15);
  EXPECT_NEAR(error.max_error, rms, 1e-15);
  const double mean = 1.75 / 3;
  EXPECT_NEAR(error.reference_mean, mean, 1e-15);
  const double floor = 0.01 * mean * mean;
  EXPECT_NEAR(error.relative_mse, (0.0625 / (0.25 + floor) + 0.25 / (1 + floor)) / 3, 1e-15);
}

TEST(Metrics, MeanOfRmsIsNotRmsOfMean) {
  // Eq. 7 takes the root before the mean: one pixel off by (3, 0, 0), three exact.
  const Image reference = constant_image(2, 2, vec3(1));
  Image image = reference;
  image.pixels[0] = 4;
  const ImageError error = compare_images(image, reference);
  EXPECT_NEAR(error.error_image, std::sqrt(3.0) / 4, 1e-15);
  EXPECT_NEAR(error.rmse, std::sqrt(9.0 / 12), 1e-15);
  EXPECT_NEAR(error.max_error, std::sqrt(3.0), 1e-15);
}

TEST(Metrics, CoverageSelectsPixels) {
  Image reference = constant_image(4, 1, vec3(0));
  Image image = reference;
  image.pixels[3] = image.pixels[4] = image.pixels[5] = 0.5f;  // the second pixel
  const ImageError implied = compare_images(image, reference);
  EXPECT_EQ(implied.covered_pixels, 1u);
  EXPECT_NEAR(implied.error_covered, 0.5, 1e-15);
  EXPECT_NEAR(implied.error_image, 0.125, 1e-15);
  const std::vector<float> coverage = {0.0f, 0.1f, 1.0f, 0.0f};
  const ImageError given = compare_images(image, reference, coverage);
  EXPECT_EQ(given.covered_pixels, 2u);
  EXPECT_NEAR(given.error_covered, 0.25, 1e-15);
}

TEST(Metrics, BlackReferenceStaysFinite) {
  const ImageError error =
      compare_images(constant_image(3, 3, vec3(2)), constant_image(3, 3, vec3(0)));
  EXPECT_TRUE(std::isfinite(error.relative_mse));
  EXPECT_GT(error.relative_mse, 1);
  const ImageError black =
      compare_images(constant_image(3, 3, vec3(0)), constant_image(3, 3, vec3(0)));
  EXPECT_EQ(black.covered_pixels, 0u);
  EXPECT_EQ(black.error_covered, 0);
  EXPECT_EQ(black.relative_mse, 0);
}

TEST(Metrics, PicturesWithoutPixelsHaveNoError) {
  const ImageError error = compare_images(Image(0, 5), Image(0, 5));
  EXPECT_EQ(error.pixels, 0u);
  for (const double value : {error.error_image, error.error_covered, error.rmse, error.relative_mse,
                             error.reference_mean, error.max_error}) {
    EXPECT_EQ(value, 0);
  }
}

TEST(Metrics, ScaleWithBothImages) {
  const Image a = random_image(40, 30, 2);
  const Image b = random_image(40, 30, 3);
  Image a4 = a;
  Image b4 = b;
  for (float& value : a4.pixels) value *= 4;
  for (float& value : b4.pixels) value *= 4;
  const ImageError small = compare_images(a, b);
  const ImageError large = compare_images(a4, b4);
  EXPECT_NEAR(large.error_image, 4 * small.error_image, 1e-13);
  EXPECT_NEAR(large.relative_mse, small.relative_mse, 1e-12);
}

TEST(Metrics, SumsAreCompensated) {
  // 1 + a million times 1e-17 is lost by a plain sum; here the small part must survive.
  const int width = 1000;
  Image reference(width, 1001);
  Image image(width, 1001);
  const float tiny = 1e-17f;
  for (float& value : image.pixels) value = tiny;
  for (size_t c = 0; c < 3; ++c) image.pixels[c] = 1;
  const ImageError error = compare_images(image, reference);
  const double pixels = 1000.0 * 1001.0;
  const double expected = 1 + (pixels - 1) * double{tiny};
  EXPECT_NEAR(error.error_image * pixels - 1, expected - 1, 1e-15);
  EXPECT_GT(error.error_image * pixels, 1);
}

TEST(Metrics, UnequalSizesAreAUsageError) {
  try {
    compare_images(Image(4, 5), Image(5, 4));
    FAIL() << "no exception";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::usage);
    EXPECT_NE(std::string(error.what()).find("4 x 5"), std::string::npos) << error.what();
  }
}

TEST(Metrics, ErrorImageAveragesToEquation7) {
  const Image a = random_image(64, 48, 4);
  const Image b = random_image(64, 48, 5);
  const Image error = error_image(a, b);
  ASSERT_EQ(error.channels, 1);
  double sum = 0;
  for (const float value : error.pixels) sum += value;
  EXPECT_NEAR(sum / (64 * 48), compare_images(a, b).error_image, 1e-7);
}

TEST(Metrics, MeanOverCoveredPixelsLeavesOutTheOthers) {
  const std::vector<float> values = {1, 2, 4, 100};
  EXPECT_DOUBLE_EQ(mean_covered(values, std::vector<float>{0.1f, 0, 1, 0}), 2.5);
  EXPECT_DOUBLE_EQ(mean_covered(values, {}), 26.75);
  EXPECT_DOUBLE_EQ(mean_covered(values, std::vector<float>(4, 0.0f)), 0);
  EXPECT_DOUBLE_EQ(mean_covered({}, {}), 0);
}

}  // namespace
}  // namespace relume

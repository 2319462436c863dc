// Colours by an OpenColorIO configuration that the test writes.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/image/color_config.h"
#include "core/image/display_transform.h"
#include "core/image/image_io.h"
#include "core/math/color.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/color_config_file.h"
#include "tests/support/expect_error.h"

namespace relume::test {
namespace {

class ColorConfig : public testing::Test {
 protected:
  ColorConfigFile config_;
  const TemporaryFolder& folder_ = config_.folder();
};

TEST_F(ColorConfig, ShowsThePictureUnclamped) {
  Image image(2, 1);
  image.pixels = {0.5f, 4, 0.125f, 8, 0.25f, 0};
  const Image shown = apply_config_view(image, 0);
  const std::vector<float> expected = {0.5f, 2, 0.5f, 2, 0.5f, 0};
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(shown.pixels[i], expected[i], 1e-5) << i;
  const Image brighter = apply_config_view(image, 2);
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(brighter.pixels[i], 2 * expected[i], 1e-5) << i;
}

TEST_F(ColorConfig, TakesColoursToSceneLinearUnclamped) {
  const ColorConverter converter("shown", "here");
  std::array<float, 3> rgb = {1, 2, 0.5f};
  converter.to_scene_linear(rgb.data());
  EXPECT_NEAR(rgb[0], 2, 1e-5);
  EXPECT_NEAR(rgb[1], 4, 1e-5);
  EXPECT_NEAR(rgb[2], 0.125, 1e-5);
}

TEST_F(ColorConfig, TexturesNameTheirSpace) {
  Image image(1, 1);
  image.pixels = {0.5f, 0.6f, 0.8f};
  const std::vector<ExrLayer> layers = {{"", {"R", "G", "B"}, &image}};
  write_exr(folder_.file("t.exr"), layers);
  const auto load = [&](const std::string& key) {
    return parse_scene(R"({"camera": {"fit": true}, "lights": [], "materials": [
        {"name": "a", "shader": "lambert", "diffuse": {"texture": "t.exr", )" +
                           key + R"(}},
        {"name": "b", "shader": "lambert", "diffuse": {"texture": "t.exr"}}],
        "geometry": [{"generator": "sphere", "material": "a"}]})",
                       folder_.file("scene.json"), shader_table());
  };
  const Scene scene = load(R"("color_space": "shown")");
  ASSERT_EQ(scene.textures.size(), 2u);
  const std::array<float, 3> expected = {0.5f, 0.36f, 0.32f};
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(scene.textures[0].texels[c], 255 * srgb_from_linear(expected[c]), 1) << c;
    EXPECT_NEAR(scene.textures[1].texels[c], 255 * srgb_from_linear(image.pixels[c]), 1) << c;
  }
  EXPECT_TRUE(scene.textures[0].srgb);
  EXPECT_ERROR(load(R"("color_space": "nowhere")"), ErrorKind::input, "'nowhere'");
  EXPECT_ERROR(load(R"("color_space": "shown", "srgb": true)"), ErrorKind::input, "keep one");
  unsetenv("OCIO");
  EXPECT_ERROR(load(R"("color_space": "shown")"), ErrorKind::input, "set OCIO");
}

TEST_F(ColorConfig, OnesThatCannotBeReadAreTold) {
  const Image image(1, 1);
  setenv("OCIO", folder_.file("none.ocio").c_str(), 1);
  EXPECT_ERROR(apply_config_view(image, 0), ErrorKind::input, "OCIO");
  write_all(folder_.file("none.ocio"), "ocio_profile_version: [");
  EXPECT_ERROR(apply_config_view(image, 0), ErrorKind::input, "OCIO");
  setenv("OCIO", "", 1);
  EXPECT_FALSE(has_color_config());
}

/// Colours over the octaves of brightness and the saturations that pictures have, with black.
Image make_frame() {
  Image image(96, 64);
  Random random(3, RandomStream::tests, 0);
  for (size_t i = 0; i < image.pixel_count(); ++i) {
    const float octave = random.uniform(-9, 3);
    const float brightness = i % 7 == 0 ? 0.0f : std::exp2(octave);
    for (size_t c = 0; c < 3; ++c) {
      image.pixels[3 * i + c] = brightness * random.uniform(0.3f, 1);
    }
  }
  return image;
}

/// How two pictures differ, in code values.
struct Difference {
  int largest = 0;
  double mean = 0;
  double above_two = 0;  ///< share of the values that differ by more
};

Difference difference(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  Difference result;
  for (size_t i = 0; i < a.size(); ++i) {
    const int difference = std::abs(int{a[i]} - int{b[i]});
    result.largest = std::max(result.largest, difference);
    result.mean += difference / static_cast<double>(a.size());
    if (difference > 2) result.above_two += 1 / static_cast<double>(a.size());
  }
  return result;
}

std::vector<uint8_t> show(const Image& image, float exposure, DisplayQuality quality) {
  std::vector<uint8_t> rgba(4 * image.pixel_count());
  apply_display_rgba(image, {exposure, ToneCurve::config}, rgba, quality);
  return rgba;
}

TEST_F(ColorConfig, CurveIsTheViewToTheByte) {
  const Image image = make_frame();
  const DisplayTransform transform{0.7f, ToneCurve::config};
  const DisplayImage rgb = apply_display(image, transform);
  EXPECT_EQ(rgb.pixels, quantize_display(apply_config_view(image, 0.7f)).pixels);
  EXPECT_NE(rgb.pixels, apply_display(image, {0.7f, ToneCurve::srgb}).pixels);
  const std::vector<uint8_t> rgba = show(image, 0.7f, DisplayQuality::exact);
  for (size_t i = 0; i < rgba.size(); ++i) {
    ASSERT_EQ(rgba[i], i % 4 == 3 ? 255 : rgb.pixels[i / 4 * 3 + i % 4]) << i;
  }
}

TEST_F(ColorConfig, CurveIsEqualForAnyThreadCount) {
  const Image image = make_frame();
  for (const DisplayQuality quality : {DisplayQuality::draft, DisplayQuality::exact}) {
    set_thread_count(1);
    const std::vector<uint8_t> one = show(image, 0, quality);
    set_thread_count(4);
    EXPECT_EQ(show(image, 0, quality), one);
    set_thread_count(0);
  }
}

TEST_F(ColorConfig, TableIsMadeOnceAndShowsTheView) {
  const ConfigView view;
  const ViewTable* const table = &view.table();
  ASSERT_NE(table, nullptr);
  EXPECT_EQ(&view.table(), table);
  std::array<float, 6> quick = {0.5f, 4, 0.125f, 8, 0.25f, 0.01f};
  std::array<float, 6> exact = quick;
  table->apply(quick);
  view.apply(exact);
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(quick[i], exact[i], 1.0 / 255) << i;
}

TEST_F(ColorConfig, DraftIsNearTheView) {
  const Image image = make_frame();
  for (const float exposure : {-2.0f, 0.0f, 1.3f}) {
    const Difference found = difference(show(image, exposure, DisplayQuality::draft),
                                        show(image, exposure, DisplayQuality::exact));
    EXPECT_LE(found.largest, 1) << exposure;
    EXPECT_LE(found.mean, 0.1) << exposure;
  }
}

TEST_F(ColorConfig, DraftOfExtremesIsNearTheView) {
  Image image(4096, 3);
  for (size_t i = 0; i < 4096; ++i) {
    const float value = std::exp2(-30.0f + 36.0f * static_cast<float>(i) / 4095);
    for (size_t row = 0; row < 3; ++row) {
      float* const rgb = image.at(static_cast<int>(i), static_cast<int>(row));
      rgb[0] = value;
      rgb[1] = row == 0 ? value : 0;
      rgb[2] = row == 2 ? -value : value * 1e-3f;
    }
  }
  EXPECT_LE(difference(show(image, 0, DisplayQuality::draft), show(image, 0, DisplayQuality::exact))
                .largest,
            1);
}

TEST_F(ColorConfig, DraftIsTheViewBeyondItsTable) {
  Image image(2, 3);
  const float infinity = std::numeric_limits<float>::infinity();
  image.pixels = {65,    0.3f, 0.2f, 1e30f, 200,      0.1f, 0.1f, -0.2f, 0.2f,
                  -1e9f, 2,    3,    0.5f,  infinity, 0,    0.3f, 0.4f,  0.5f};
  const std::vector<uint8_t> draft = show(image, 0, DisplayQuality::draft);
  const std::vector<uint8_t> exact = show(image, 0, DisplayQuality::exact);
  for (size_t i = 0; i < 20; ++i) ASSERT_EQ(draft[i], exact[i]) << i;
}

TEST_F(ColorConfig, DraftOfAPixelIsTheSameWhateverItsNeighbours) {
  const std::array<vec3, 4> colors = {
      vec3(0.5f, 0.3f, 0.2f), {1e30f, 200, 0.1f}, {0.01f, 2, 3}, {-1e9f, 2, 3}};
  Image all(4, 1);
  for (size_t i = 0; i < 4; ++i) std::copy_n(&colors[i].x, 3, &all.pixels[3 * i]);
  const std::vector<uint8_t> together = show(all, 0, DisplayQuality::draft);
  for (size_t i = 0; i < 4; ++i) {
    Image one(1, 1);
    std::copy_n(&colors[i].x, 3, one.pixels.data());
    const std::vector<uint8_t> alone = show(one, 0, DisplayQuality::draft);
    for (size_t c = 0; c < 4; ++c) EXPECT_EQ(together[4 * i + c], alone[c]) << i << " " << c;
  }
}

TEST(ColorConfigOfFilms, DraftIsNearTheView) {
  const ColorConfigFile config(aces_config);
  const Image image = make_frame();
  try {
    config_view();
  } catch (const Error& error) {
    GTEST_SKIP() << "this OpenColorIO has no ACES: " << error.what();
  }
  const Difference found =
      difference(show(image, 0, DisplayQuality::draft), show(image, 0, DisplayQuality::exact));
  EXPECT_LE(found.mean, 0.2);
  EXPECT_LE(found.above_two, 0.01) << "where its gamut ends";
}

TEST_F(ColorConfig, TwoInOneProcessShowTheirOwn) {
  const Image image = make_frame();
  const std::vector<uint8_t> first = show(image, 0, DisplayQuality::exact);
  write_all(folder_.file("other.ocio"),
            std::string(square_root_config)
                .replace(std::string(square_root_config).find("0.5, 0, 0"), 3, "0.1"));
  setenv("OCIO", folder_.file("other.ocio").c_str(), 1);
  EXPECT_NE(show(image, 0, DisplayQuality::exact), first);
  setenv("OCIO", folder_.file("config.ocio").c_str(), 1);
  EXPECT_EQ(show(image, 0, DisplayQuality::exact), first);
}

TEST(CurveConfig, IsTheDefaultWhereThereIsAConfigurationAndToldWhereNot) {
  EXPECT_EQ(default_curve(), ToneCurve::srgb);
  const Image image(1, 1);
  EXPECT_ERROR(apply_display(image, {0, ToneCurve::config}), ErrorKind::input, "set OCIO");
  const ColorConfigFile config;
  EXPECT_EQ(default_curve(), ToneCurve::config);
}

TEST(QuantizeDisplay, CutsWhatAScreenCannotShow) {
  Image image(4, 1, 1);
  image.pixels = {-1, std::nanf(""), 0.5f, 7};
  EXPECT_EQ(quantize_display(image).pixels, (std::vector<uint8_t>{0, 0, 128, 255}));
}

}  // namespace
}  // namespace relume::test

// Colours by an OpenColorIO configuration that the test writes.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "core/image/color_config.h"
#include "core/image/image_io.h"
#include "core/math/color.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace relume::test {
namespace {

/// `shown` is the square root of the scene's colours, of which red is halved and blue doubled.
constexpr const char* config_text = R"(ocio_profile_version: 1
strictparsing: true
roles: {default: raw, scene_linear: lin}
displays:
  screen:
    - !<View> {name: look, colorspace: shown}
colorspaces:
  - !<ColorSpace> {name: lin, bitdepth: 32f}
  - !<ColorSpace> {name: raw, isdata: true}
  - !<ColorSpace>
    name: shown
    bitdepth: 32f
    from_reference: !<GroupTransform>
      children:
        - !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
        - !<ExponentTransform> {value: [0.5, 0.5, 0.5, 1]}
)";

class ColorConfig : public testing::Test {
 protected:
  ColorConfig() {
    write_all(folder_.file("config.ocio"), config_text);
    setenv("OCIO", folder_.file("config.ocio").c_str(), 1);
  }
  ~ColorConfig() override { unsetenv("OCIO"); }

  TemporaryFolder folder_;
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

TEST(QuantizeDisplay, CutsWhatAScreenCannotShow) {
  Image image(4, 1, 1);
  image.pixels = {-1, std::nanf(""), 0.5f, 7};
  EXPECT_EQ(quantize_display(image).pixels, (std::vector<uint8_t>{0, 0, 128, 255}));
}

}  // namespace
}  // namespace relume::test

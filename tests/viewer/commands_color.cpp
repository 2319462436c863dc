// `relume render` to PNG under $OCIO.

#include <gtest/gtest.h>

#include <cstdlib>

#include "core/image/image_io.h"
#include "core/math/color.h"
#include "tests/support/temporary_folder.h"
#include "viewer/commands/commands.h"

namespace relume::test {
namespace {

TEST(ColorOfRender, PngIsWhatTheConfigurationShowsUnlessACurveIsGiven) {
  const TemporaryFolder folder;
  write_all(folder.file("config.ocio"), R"(ocio_profile_version: 1
roles: {default: lin, scene_linear: lin}
displays:
  screen:
    - !<View> {name: look, colorspace: shown}
colorspaces:
  - !<ColorSpace> {name: lin, bitdepth: 32f}
  - !<ColorSpace>
    name: shown
    bitdepth: 32f
    from_reference: !<MatrixTransform> {matrix: [0.25, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}
)");
  RenderOptions options;
  options.input = "spheres";
  options.prepare.width = 40;
  options.prepare.height = 36;
  options.prepare.spp = 4;
  options.exposure = 0.0f;
  const auto render = [&](const std::string& name) {
    options.output = folder.file(name);
    testing::internal::CaptureStdout();
    run_render(options, {.quiet = true});
    testing::internal::GetCapturedStdout();
    return read_image(options.output);
  };
  const Image frame = render("frame.exr");
  const Image plain = render("plain.png");
  setenv("OCIO", folder.file("config.ocio").c_str(), 1);
  const Image shown = render("shown.png");
  options.curve = ToneCurve::srgb;
  const Image curve = render("curve.png");
  unsetenv("OCIO");
  EXPECT_EQ(curve.pixels, plain.pixels);
  const vec3 scale(0.25f, 0.5f, 1);
  for (size_t i = 0; i < frame.pixel_count(); ++i) {
    for (int c = 0; c < 3; ++c) {
      // A PNG is read as sRGB.
      const float expected = std::min(scale[c] * frame.rgb(i)[c], 1.0f);
      ASSERT_NEAR(srgb_from_linear(shown.rgb(i)[c]), expected, 0.51 / 255) << i;
    }
  }
}

}  // namespace
}  // namespace relume::test

// AOV images without a proxy: the camera follows from the positions, the samples cast the shadows.

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "viewer/aovs/fit_camera.h"
#include "viewer/commands/commands.h"

namespace relume::test {
namespace {

const CommonOptions quiet{.quiet = true};

/// Points before a camera, where it sees them; where `is_flat`, in one plane.
std::vector<SeenPoint> see(const Camera& camera, int width, int height, bool is_flat) {
  const CameraRays rays(camera, width, height);
  Random random(3, RandomStream::lights, 0);
  std::vector<SeenPoint> points;
  while (points.size() < 500) {
    const vec2 film(random.uniform() * static_cast<float>(width),
                    random.uniform() * static_cast<float>(height));
    const float distance =
        is_flat ? 5 / glm::dot(rays.direction(film), rays.forward()) : 4 + 3 * random.uniform();
    points.push_back({rays.eye() + distance * rays.direction(film), film});
  }
  return points;
}

TEST(FitCamera, FindsTheCameraThatSawThePoints) {
  for (const Camera& camera :
       {Camera{.eye = {1, 2, 3}, .target = {0, 0, -1}, .fov_y_deg = 50},
        Camera{.eye = {100, 0, 0}, .target = {99, 4, 1}, .up = {0, 0, 1}},
        Camera{.eye = {0, 0, 0}, .target = {0, 1, 0}, .up = {1, 0, 0}, .fov_y_deg = 90}}) {
    const auto found = fit_camera(see(camera, 320, 200, false), 320, 200);
    ASSERT_TRUE(found);
    EXPECT_NEAR(glm::distance(found->eye, camera.eye), 0, 1e-3);
    EXPECT_NEAR(found->fov_y_deg, camera.fov_y_deg, 0.01f);
    const CameraRays expected(camera, 320, 200);
    const CameraRays rays(*found, 320, 200);
    EXPECT_NEAR(glm::distance(rays.forward(), expected.forward()), 0, 1e-4);
    EXPECT_NEAR(glm::distance(rays.up(), expected.up()), 0, 1e-4);
  }
}

TEST(FitCamera, SaysNothingWherePointsDoNotTell) {
  const Camera camera{.eye = {1, 2, 3}, .target = {0, 0, -1}};
  const std::vector<SeenPoint> points = see(camera, 320, 200, false);
  EXPECT_FALSE(fit_camera(std::span(points).first(10), 320, 200));
  EXPECT_FALSE(fit_camera(see(camera, 320, 200, true), 320, 200));
  EXPECT_FALSE(fit_camera(std::vector<SeenPoint>(100, points[0]), 320, 200));
}

/// A scene's samples as an image, prepared with and without the scene as the proxy.
class Splats : public testing::TestWithParam<const char*> {
 protected:
  static constexpr int side = 3;

  /// Runs a command whose figures and messages are not looked at.
  template <class Work>
  static void silently(const Work& work) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    try {
      work();
    } catch (...) {
      testing::internal::GetCapturedStdout();
      testing::internal::GetCapturedStderr();
      throw;
    }
    testing::internal::GetCapturedStdout();
    testing::internal::GetCapturedStderr();
  }

  void sample(const std::string& scene) {
    silently([&] {
      run_sample(
          {.scene = scene, .output = file_, .samples_per_side = side, .width = 120, .height = 96},
          quiet);
    });
  }

  std::string prepare(const std::string& name, const std::string& proxy) {
    PrepareCommandOptions options;
    options.scene = file_.string();
    options.output = folder_.file(name);
    options.channels = "relume";
    options.samples_per_side = side;
    options.proxy = proxy;
    options.prepare.method = ReductionMethod::all;
    silently([&] { run_prepare(options, quiet); });
    return options.output.string();
  }

  Image render(const std::string& cache, ShadowMethod shadow) {
    RenderOptions options;
    options.input = cache;
    options.output = folder_.file("frame.exr");
    options.shadow = shadow;
    options.lights = folder_.file("lights.json");
    silently([&] { run_render(options, quiet); });
    return read_image(options.output);
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.file("aovs.exr");
};

TEST_P(Splats, CameraIsFoundAndSamplesCastShadows) {
  sample(GetParam());
  const std::string own = prepare("own.relume", "");
  const std::string known = prepare("known.relume", GetParam());
  const Scene scene = load_scene(GetParam(), shader_table());
  const Scene found = load_scene(folder_.file("own.proxy.json").string(), shader_table());
  const float distance = glm::distance(scene.camera.eye, world_bounds(scene).center());
  EXPECT_LT(glm::distance(found.camera.eye, scene.camera.eye), 0.01f * distance);
  EXPECT_NEAR(found.camera.fov_y_deg, scene.camera.fov_y_deg, 0.3f);
  write_all(folder_.file("lights.json"), format_lights(scene.lights));
  const Image truth = render(known, ShadowMethod::ray);
  const double error = compare_images(render(own, ShadowMethod::ray), truth).error_covered;
  const double unshadowed = compare_images(render(own, ShadowMethod::none), truth).error_covered;
  EXPECT_GT(unshadowed, 0);
  EXPECT_LT(error, 0.7 * unshadowed);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Splats, testing::Values("spheres", "hair"));

TEST_F(Splats, FlatThingsWantAProxy) {
  write_all(folder_.file("wall.json"), R"({"camera": {"eye": [0, 3, 0], "target": [0, 0, 0],
      "up": [0, 0, 1]}, "lights": [], "materials": [{"name": "a", "shader": "lambert"}],
      "geometry": [{"generator": "plane", "half_size": [9, 9], "material": "a"}]})");
  sample(folder_.file("wall.json").string());
  EXPECT_ERROR(prepare("own.relume", ""), ErrorKind::input, "give --proxy");
  EXPECT_FALSE(std::filesystem::exists(folder_.file("own.proxy.json")));
}

}  // namespace
}  // namespace relume::test

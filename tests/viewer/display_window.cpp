// The real window, under a virtual X server. Windows live in processes of their own, because an
// off-screen context redirects the OpenGL functions of a window in the same one: the tests start
// this very program again with a filter for one of the DISABLED_ tests, which play the part of the
// person's program.

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>

#include "core/base/error.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/child_process.h"
#include "tests/viewer/fake_session.h"
#include "tests/viewer/x_server.h"
#include "viewer/display/run_viewer.h"

namespace relume {
namespace {

using namespace std::chrono_literals;

constexpr const char* folder_variable = "RELUME_TEST_FOLDER";
constexpr const char* script_text =
    "screenshot frame.png\n"
    "drag handle.1 120 40\n"
    "click lights.2\n"
    "click light.type.spot\n"
    "click view.heatmap\n"
    "screenshot heatmap.png\n"
    "resize 777 333\n"
    "key ?\n"
    "screenshot help.png\n"
    "resize 1 1\n"
    "resize 1280 800\n"
    "key ?\n"
    "key r\n"
    "screenshot reference.png\n";

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

std::filesystem::path helper_folder() {
  const char* folder = std::getenv(folder_variable);
  return folder == nullptr ? std::filesystem::path() : std::filesystem::path(folder);
}

std::filesystem::path fresh_folder(const std::string& name) {
  static const test::TemporaryFolder of_this_process;
  const std::filesystem::path folder = of_this_process.file(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// Options for AddressSanitizer in a part: graphics drivers leak, and are unloaded before the leaks
/// are reported, so that they cannot be told by name.
std::string sanitizer_options() {
  const char* ours = std::getenv("ASAN_OPTIONS");
  return std::string(ours == nullptr ? "" : ours) + ":detect_leaks=0";
}

/// This program again, running one DISABLED_ test on `display`.
std::unique_ptr<ChildProcess> start_part(const std::string& part, const std::string& display,
                                         const std::filesystem::path& folder) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  return std::make_unique<ChildProcess>(
      std::vector<std::string>{program, "--gtest_also_run_disabled_tests",
                               "--gtest_filter=DISABLED_Part." + part},
      std::map<std::string, std::string>{{"DISPLAY", display},
                                         {"WAYLAND_DISPLAY", ""},
                                         {"GTEST_SHARD_INDEX", "0"},
                                         {"GTEST_TOTAL_SHARDS", "1"},
                                         {"ASAN_OPTIONS", sanitizer_options()},
                                         {folder_variable, folder.string()}});
}

TEST(DISABLED_Part, PlaysTheScriptInAWindow) {
  ASSERT_FALSE(helper_folder().empty()) << "run by the tests below";
  Workspace workspace(std::make_unique<Session>(make_fake_parts()));
  WindowOptions options;
  options.ui_scale = 1;
  options.script = parse_script(script_text, "test");
  options.folder = helper_folder();
  EXPECT_EQ(run_window(workspace, options), 0);
}

TEST(DISABLED_Part, ServesAPerson) {
  ASSERT_FALSE(helper_folder().empty()) << "run by the tests below";
  Workspace workspace(std::make_unique<Session>(make_fake_parts()));
  WindowOptions options;
  options.ui_scale = 1;
  EXPECT_EQ(run_window(workspace, options), 0);
  const Light& light = workspace.session()->view().lights[0];
  std::ofstream(helper_folder() / "result.txt")
      << light.position.x << ' ' << light.position.y << ' ' << light.position.z << ' '
      << workspace.session()->view().display.exposure << ' '
      << label_of(shown_picture_labels, workspace.session()->view().shown) << '\n';
}

TEST(DISABLED_Part, TakesDropsAndANewContext) {
  ASSERT_FALSE(helper_folder().empty()) << "run by the tests below";
  GlfwWindow window("drops", {320, 200});
  std::vector<std::string> dropped;
  window.set_drop([&dropped](const std::string& path) { dropped.push_back(path); });
  const auto drop = [](std::vector<const char*> paths) {
    GLFWwindow* handle = glfwGetCurrentContext();
    const GLFWdropfun callback = glfwSetDropCallback(handle, nullptr);
    ASSERT_NE(callback, nullptr);
    callback(handle, static_cast<int>(paths.size()), paths.data());
    glfwSetDropCallback(handle, callback);
  };
  drop({"one.json", "two.relume"});
  const GlTable before = load_gl_table(window.loader());
  GLuint texture = 0;
  before.GenTextures(1, &texture);
  const ivec2 size = window.size_px();
  window.renew_context();
  EXPECT_EQ(window.size_px(), size);
  EXPECT_FALSE(window.is_context_lost());
  const GlTable after = load_gl_table(window.loader());
  require_no_gl_error(after, "a new context");
  drop({"three.json"});
  EXPECT_EQ(dropped, (std::vector<std::string>{"one.json", "two.relume", "three.json"}));
  std::ofstream(helper_folder() / "result.txt") << (HasFailure() ? "failed" : "done");
}

TEST_F(Window, TakesDroppedFilesAndGoesOnInANewWindow) {
  const std::filesystem::path folder = fresh_folder("relume_drops");
  EXPECT_EQ(start_part("TakesDropsAndANewContext", display_, folder)->wait(60s), 0);
  EXPECT_EQ(read_bytes(folder / "result.txt"), "done");
}

TEST_F(Window, DrawsTheSameBytesAsOffscreen) {
  const std::filesystem::path in_window = fresh_folder("relume_window");
  const std::filesystem::path off_screen = fresh_folder("relume_offscreen");
  ASSERT_EQ(start_part("PlaysTheScriptInAWindow", display_, in_window)->wait(120s), 0);

  Workspace workspace(std::make_unique<Session>(make_fake_parts()));
  ASSERT_EQ(run_offscreen(workspace, parse_script(script_text, "test"), off_screen), 0);
  for (const char* file : {"frame.png", "heatmap.png", "help.png", "reference.png"}) {
    const std::string bytes = read_bytes(off_screen / file);
    EXPECT_GT(bytes.size(), 1000u) << file;
    EXPECT_TRUE(bytes == read_bytes(in_window / file)) << file << " differs";
  }
}

TEST_F(Window, APersonDragsALightAndLeaves) {
  if (xdotool({"version"}) != 0) GTEST_SKIP() << "needs xdotool: apt-get install xdotool";
  const std::filesystem::path folder = fresh_folder("relume_person");
  const auto program = start_part("ServesAPerson", display_, folder);
  ASSERT_EQ(xdotool({"search", "--sync", "--onlyvisible", "--name", "^Relume"}), 0);
  // Without a window manager the window stands at the top left. Without the panel the 320 x 240
  // picture fills about 1280 x 748, below the menus, with light 1 in the middle.
  const auto pause = [] { std::this_thread::sleep_for(200ms); };
  xdotool({"mousemove", "640", "398"});
  pause();
  xdotool({"key", "p"});
  pause();
  xdotool({"mousedown", "1"});
  pause();
  for (const char* x : {"670", "700", "730"}) xdotool({"mousemove", x, "398"});
  pause();
  xdotool({"mouseup", "1"});
  pause();
  xdotool({"key", "h"});
  xdotool({"key", "minus"});
  pause();
  xdotool({"key", "q"});
  ASSERT_EQ(program->wait(60s), 0);

  std::ifstream result(folder / "result.txt");
  vec3 position(0);
  float exposure = 0;
  std::string shown;
  result >> position.x >> position.y >> position.z >> exposure >> shown;
  // 90 screen pixels at depth 5 under 17.5 degrees of half angle.
  const float expected = 90 / (748.0f / 240) * 2 * 5 * std::tan(radians_from_degrees(17.5f)) / 240;
  EXPECT_NEAR(position.x, expected, 0.01);
  EXPECT_NEAR(position.y, 0, 1e-6);
  EXPECT_NEAR(position.z, 0, 1e-6);
  EXPECT_EQ(exposure, -0.5f);
  EXPECT_EQ(shown, "heatmap");
}

TEST(WindowWithoutDisplay, FailsWithOneClearError) {
  // In a process of its own: the environment is read once.
  const std::filesystem::path folder = fresh_folder("relume_no_display");
  EXPECT_EQ(start_part("FindsNoDisplay", ":99999", folder)->wait(60s), 0);
  EXPECT_TRUE(std::filesystem::exists(folder / "result.txt")) << "the part did not run";
}

TEST(DISABLED_Part, FindsNoDisplay) {
  ASSERT_FALSE(helper_folder().empty()) << "run by the test above";
  EXPECT_FALSE(display_available());
  Workspace workspace(std::make_unique<Session>(make_fake_parts()));
  try {
    run_window(workspace, {});
    FAIL() << "a window without a display";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::output);
    EXPECT_NE(std::string(error.what()).find("--offscreen"), std::string::npos) << error.what();
    std::ofstream(helper_folder() / "result.txt") << error.what() << '\n';
  }
}

}  // namespace
}  // namespace relume

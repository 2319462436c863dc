// The program as a person uses it, in a window on a virtual X server: nothing is looked up inside
// of it, only the files that it writes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <thread>

#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/x_server.h"
#include "viewer/display/osmesa_surface.h"
#include "viewer/display/script_player.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

using namespace std::chrono_literals;
using test::read_all;
using test::TemporaryFolder;

constexpr int side = 64;  // pixels

/// Where the window shows the handle of the spheres' first light.
vec2 first_handle() {
  auto scene = std::make_unique<const Scene>(load_scene("spheres", shader_table()));
  auto tracer = std::make_unique<const Tracer>(*scene);
  PrepareParams params;
  params.spp = 1;
  params.reduction.records = 1;
  params.width = params.height = side;
  RelightCache cache = prepare_in_memory(*scene, *tracer, params, {});
  Workspace workspace(std::unique_ptr<Session>(
      new Session(make_session(std::move(scene), std::move(tracer), std::move(cache), {}))));
  OsmesaSurface surface({1280, 800});
  GlTable gl = load_gl_table(surface.loader());
  Screen screen(workspace, gl, {.scale = 1, .show_timings = false});
  play_script(parse_script("wait", "test"), workspace, screen, gl, surface, {});
  return screen.ui().items.find("handle.1").value_or(Rect{}).center();
}

class Person : public Window {
 protected:
  void SetUp() override {
    Window::SetUp();
    if (IsSkipped()) return;
    if (xdotool({"version"}) != 0) GTEST_SKIP() << "needs xdotool: apt-get install xdotool";
  }

  std::unique_ptr<ChildProcess> start(const std::string& input) {
    const std::string command = fmt::format(
        "cd '{}' && exec '{}' view {} --keep-records --width {} --height {} --spp 4 --records 2 -q",
        folder_.path().string(), RELUME_PROGRAM, input, side, side);
    std::filesystem::remove(state() / "recent.json");
    auto program = std::make_unique<ChildProcess>(
        std::vector<std::string>{"sh", "-c", command},
        std::map<std::string, std::string>{{"DISPLAY", display_},
                                           {"WAYLAND_DISPLAY", ""},
                                           {"ASAN_OPTIONS", "detect_leaks=0"},
                                           {"XDG_STATE_HOME", folder_.path().string()}});
    EXPECT_EQ(xdotool({"search", "--sync", "--onlyvisible", "--name", "^Relume"}), 0);
    EXPECT_TRUE(appears(state() / "recent.json")) << "the session is not open";
    xdotool({"mousemove", "300", "400"});
    pause();
    return program;
  }

  std::filesystem::path state() const { return folder_.path() / "relume"; }
  static void pause() { std::this_thread::sleep_for(250ms); }

  /// Waits for a file.
  static bool appears(const std::filesystem::path& file) {
    for (int i = 0; i < 300; ++i) {
      if (std::filesystem::exists(file)) return true;
      std::this_thread::sleep_for(50ms);
    }
    return false;
  }

  /// Waits for an autosaved session other than `before`; its text.
  std::string wait_for_autosave(const std::string& before) const {
    for (int i = 0; i < 200; ++i) {
      for (const auto& entry : std::filesystem::directory_iterator(state())) {
        const std::string name = entry.path().filename().string();
        if (!name.starts_with("autosave-") || entry.path().extension() != ".json") continue;
        std::string text = read_all(entry.path());
        if (text != before) return text;
      }
      std::this_thread::sleep_for(50ms);
    }
    return {};
  }

  void press(const std::string& key) {
    xdotool({"key", key});
    pause();
  }

  void drag(vec2 from, vec2 by) {
    const auto move = [&](vec2 to) {
      xdotool({"mousemove", fmt::format("{:.0f}", to.x), fmt::format("{:.0f}", to.y)});
    };
    move(from);
    pause();
    xdotool({"mousedown", "1"});
    pause();
    for (const float part : {0.3f, 0.7f, 1.0f}) move(from + by * part);
    pause();
    xdotool({"mouseup", "1"});
    pause();
  }

  /// The bytes of the frame that is shown, exported.
  std::string export_frame() {
    const auto file = folder_.file(fmt::format("spheres-{:03}.exr", ++exports_));
    press("ctrl+e");
    EXPECT_TRUE(appears(file)) << file;
    return read_all(file);
  }

  TemporaryFolder folder_;
  int exports_ = 0;
};

TEST_F(Person, DragsUndoesSavesIsKilledAndGoesOn) {
  const vec2 handle = first_handle();
  auto program = start("spheres");
  const std::string at_first = export_frame();
  drag(handle, vec2(-120, 90));
  const std::string dragged = export_frame();
  EXPECT_TRUE(dragged != at_first) << "the picture changes";
  press("ctrl+z");
  EXPECT_TRUE(export_frame() == at_first) << "undone";
  press("ctrl+shift+z");
  EXPECT_TRUE(export_frame() == dragged) << "done again";

  press("ctrl+s");
  xdotool({"type", folder_.file("mine").string()});
  press("Return");
  ASSERT_TRUE(appears(folder_.file("mine.json")));
  std::this_thread::sleep_for(1s);  // frames later its dialog takes no more keys
  const std::string saved = read_all(folder_.file("mine.json"));
  press("period");
  const std::string unsaved = wait_for_autosave(saved);
  EXPECT_NE(unsaved, "");
  const std::string brighter = export_frame();
  EXPECT_TRUE(brighter != dragged) << "a quarter stop more";
  program->kill_hard();

  EXPECT_EQ(read_all(folder_.file("mine.json")), saved);
  program = start(folder_.file("mine.json").string());
  EXPECT_TRUE(export_frame() == brighter) << "what was not saved is back";
  press("ctrl+z");
  EXPECT_TRUE(export_frame() == dragged) << "and can be undone";
  press("q");
  EXPECT_EQ(program->wait(60s), 0);
}

TEST_F(Person, LeavesWhileTheSceneIsBeingPrepared) {
  for (const char* scene : {"hair", "plants"}) {
    ChildProcess program({RELUME_PROGRAM, "view", scene, "-q", "--spp", "64"},
                         {{"DISPLAY", display_},
                          {"WAYLAND_DISPLAY", ""},
                          {"ASAN_OPTIONS", "detect_leaks=0"},
                          {"XDG_STATE_HOME", folder_.path().string()}});
    ASSERT_EQ(xdotool({"search", "--sync", "--onlyvisible", "--name", "^Relume"}), 0);
    xdotool({"mousemove", "300", "400"});
    pause();
    press("q");
    EXPECT_EQ(program.wait(60s), 0) << scene;
    EXPECT_FALSE(std::filesystem::exists(state() / "recent.json")) << "it was not open yet";
  }
}

}  // namespace
}  // namespace relume

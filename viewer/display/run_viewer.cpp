#include "viewer/display/run_viewer.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/progress.h"
#include "viewer/display/osmesa_surface.h"
#include "viewer/display/screen.h"
#include "viewer/display/script_player.h"

namespace relume {
namespace {

constexpr double idle_wake_s = 0.25;  // how long an interrupt may go unnoticed
constexpr int settle_frames = 2;      // ImGui needs two frames to lay out what changed

/// While it lives, the window's input reaches ImGui, dropped files are opened and finished work
/// wakes the event loop.
class Connection {
 public:
  Connection(Workspace& workspace, GlfwWindow& window) : workspace_(workspace), window_(window) {
    window_.connect_input();
    window_.set_drop([&workspace](const std::string& path) { workspace.open(path); });
    workspace_.set_notify(GlfwWindow::wake);
  }
  ~Connection() {
    workspace_.set_notify({});
    window_.set_drop({});
    window_.disconnect_input();
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

 private:
  Workspace& workspace_;
  GlfwWindow& window_;
};

/// Changes whenever the picture on the screen does.
std::pair<uint64_t, uint64_t> picture_version(const Workspace& workspace) {
  const Session* session = workspace.session();
  return {workspace.session_number(),
          session != nullptr ? session->picture().version : workspace.preview().version};
}

std::string window_title(const Workspace& workspace) {
  const Session* session = workspace.session();
  const std::string name =
      session != nullptr ? session->info().title : workspace.load_status().input;
  return fmt::format("Relume - {}", printable(name, 80));
}

}  // namespace

void run_events(Workspace& workspace, Screen& screen, EventSurface& window) {
  int frames_due = 1 + settle_frames;
  while (!window.should_close() && !screen.quit() && !interrupted()) {
    if (frames_due > 0) {
      window.poll_events();
    } else {
      const bool arrived = window.wait_events(idle_wake_s);
      if (!arrived && !screen.changes_by_itself()) continue;
      frames_due = arrived ? 1 + settle_frames : 1;
    }
    const auto shown = picture_version(workspace);
    window.begin_frame();
    screen.draw(window.size_px());
    window.present();
    if (window.is_context_lost()) {
      screen.renew_context(window);
      frames_due = 1 + settle_frames;
    }
    --frames_due;
    if (picture_version(workspace) != shown) frames_due = std::max(frames_due, settle_frames);
    if (window.has_pending_keys()) frames_due = std::max(frames_due, 1);
    workspace.require_session();
  }
}

int run_window(Workspace& workspace, const WindowOptions& options) {
  GlfwWindow window(window_title(workspace), options.size);
  GlTable gl = load_gl_table(window.loader());
  const float scale = options.ui_scale > 0 ? options.ui_scale : window.ui_scale();
  Screen screen(workspace, gl, {.scale = scale, .show_timings = !options.script});
  if (options.script) {
    make_folder(options.folder);
    play_script(*options.script, workspace, screen, gl, window, options.folder);
    return 0;
  }
  const Connection connection(workspace, window);
  run_events(workspace, screen, window);
  return interrupted() ? static_cast<int>(ErrorKind::cancelled) : 0;
}

int run_offscreen(Workspace& workspace, const Script& script, const std::filesystem::path& folder,
                  const OffscreenOptions& options) {
  workspace.wait(true);
  workspace.require_session();
  make_folder(folder);
  OsmesaSurface surface(options.size_px);
  GlTable gl = load_gl_table(surface.loader());
  Screen screen(workspace, gl, {.scale = options.ui_scale, .show_timings = false});
  play_script(script, workspace, screen, gl, surface, folder);
  return 0;
}

Script default_script() {
  return parse_script("screenshot window.png", "default script");
}

}  // namespace relume

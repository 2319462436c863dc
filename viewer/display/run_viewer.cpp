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

/// While it lives, the window's input reaches ImGui and finished frames wake the event loop.
class Connection {
 public:
  Connection(Session& session, GlfwWindow& window) : session_(session), window_(window) {
    window_.connect_input();
    session_.set_notify(GlfwWindow::wake);
  }
  ~Connection() {
    session_.set_notify({});
    window_.disconnect_input();
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

 private:
  Session& session_;
  GlfwWindow& window_;
};

void run_events(Session& session, Screen& screen, GlfwWindow& window) {
  int frames_due = 1 + settle_frames;
  while (!window.should_close() && !screen.quit() && !interrupted()) {
    if (frames_due > 0) {
      window.poll_events();
    } else {
      const bool arrived = window.wait_events(idle_wake_s);
      if (!arrived && !screen.has_caret()) continue;
      frames_due = arrived ? 1 + settle_frames : 1;
    }
    const uint64_t shown = session.picture().version;
    window.begin_frame();
    screen.draw(window.size_px());
    window.present();
    --frames_due;
    if (session.picture().version != shown) frames_due = std::max(frames_due, settle_frames);
  }
}

}  // namespace

int run_window(Session& session, const WindowOptions& options) {
  GlfwWindow window(fmt::format("Relume - {}", printable(session.info().title, 80)), options.size);
  const GlTable gl = load_gl_table(window.loader());
  const float scale = options.ui_scale > 0 ? options.ui_scale : window.ui_scale();
  Screen screen(session, gl, {.scale = scale, .show_timings = !options.script});
  if (options.script) {
    make_folder(options.folder);
    play_script(*options.script, session, screen, gl, window, options.folder);
    return 0;
  }
  const Connection connection(session, window);
  run_events(session, screen, window);
  return interrupted() ? static_cast<int>(ErrorKind::cancelled) : 0;
}

int run_offscreen(Session& session, const Script& script, const std::filesystem::path& folder,
                  const OffscreenOptions& options) {
  make_folder(folder);
  OsmesaSurface surface(options.size_px);
  const GlTable gl = load_gl_table(surface.loader());
  Screen screen(session, gl, {.scale = options.ui_scale, .show_timings = false});
  play_script(script, session, screen, gl, surface, folder);
  return 0;
}

Script default_script() {
  return parse_script("screenshot window.png", "default script");
}

}  // namespace relume

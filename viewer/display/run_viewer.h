#pragma once

#include <filesystem>
#include <optional>

#include "viewer/display/glfw_window.h"
#include "viewer/display/screen.h"
#include "viewer/display/script.h"
#include "viewer/session/workspace.h"

namespace relume {

struct WindowOptions {
  ivec2 size{1280, 800};         ///< screen units at 96 dpi
  float ui_scale = 0;            ///< of text and controls; 0 = as the display asks for
  std::optional<Script> script;  ///< plays it instead of listening to a person, then closes
  std::filesystem::path folder;  ///< for the script's screenshots
};

/// Opens the window and stays until it is closed. Draws only when something happened. Returns the
/// exit code. Throws Error(output) when there is no display (see display_available()), and what
/// the first input failed with when it could not be opened.
int run_window(Workspace& workspace, const WindowOptions& options);

/// Draws and listens until the window is closed, the person leaves or the program is interrupted.
/// While nothing happens nothing is drawn. Throws what the first input failed with.
void run_events(Workspace& workspace, Screen& screen, EventSurface& window);

struct OffscreenOptions {
  ivec2 size_px{1280, 800};
  float ui_scale = 1;
};

/// Draws the same without a display and plays `script`; screenshots go to `folder`, which is made
/// when missing. Two runs write the same bytes. Returns the exit code.
int run_offscreen(Workspace& workspace, const Script& script, const std::filesystem::path& folder,
                  const OffscreenOptions& options = {});

/// One screenshot, "window.png", of the viewer as it opens.
Script default_script();

}  // namespace relume

#pragma once

#include <array>
#include <string>
#include <vector>

#include "viewer/panels/item_table.h"
#include "viewer/panels/placement.h"

namespace relume {

/// What a drag in the picture holds on to.
enum class Grip { none, view_plane, axis_x, axis_y, axis_z, pan };

/// A drag in progress. The light's place follows from where the drag started, so that it does not
/// depend on how many events came between.
struct Drag {
  Grip grip = Grip::none;
  int light = -1;
  vec3 start_world{0};
  vec3 measured_world{0};  ///< where the pointer's motion is measured, see LightHandle
  vec2 start_screen{0};
};

/// The box for a path, and what it is for.
struct FileDialog {
  enum class Purpose { none, open, save, export_frame };
  struct Entry {
    std::string name;
    bool is_folder = false;
  };

  Purpose purpose = Purpose::none;  ///< none: closed
  std::array<char, 4096> path{};
  std::string folder;  ///< that `entries` lists
  std::vector<Entry> entries;
  bool is_new = false;  ///< opened since the last frame
};

/// The user interface's own state: nothing that a session would save.
struct UiState {
  ItemTable items;
  Layout layout;
  Placement placement;
  Drag drag;
  FileDialog dialog;
  bool show_timings = true;  ///< off in scripted runs, whose pictures must not depend on the clock
  bool show_help = false;
  bool show_panel = true;
  bool nudging = false;  ///< a light is being moved with the keyboard
  bool quit = false;
};

}  // namespace relume

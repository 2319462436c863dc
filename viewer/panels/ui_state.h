#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "viewer/panels/item_table.h"
#include "viewer/panels/placement.h"
#include "viewer/session/light_placement.h"
#include "viewer/session/picture_histogram.h"
#include "viewer/session/snapshots.h"
#include "viewer/session/spot_cone.h"

namespace relume {

/// What a drag in the picture holds on to. `axis_aim` runs from what the light is aimed at to the
/// light; `place` is a tool at work, see PlaceTool; `wipe` the line between a snapshot
/// and the live picture.
enum class Grip {
  none,
  view_plane,
  axis_x,
  axis_y,
  axis_z,
  axis_aim,
  aim,
  inner_cone,
  outer_cone,
  place,
  wipe,
  pan
};

/// A drag in progress. The light's place follows from where the drag started, so that it does not
/// depend on how many events came between.
struct Drag {
  Grip grip = Grip::none;
  int light = -1;
  vec3 start_world{0};
  vec3 measured_world{0};  ///< where the pointer's motion is measured, see LightHandle
  vec2 start_screen{0};
  vec3 axis{0};       ///< unit, world; of the axis_ grips
  SpotCone cone;      ///< of the cone grips
  ShadowGrip shadow;  ///< of the shadow tool
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

/// What the pointer stays on.
struct Tip {
  std::string item;  ///< empty: nothing that has a tip
  float seconds = 0;
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
  Tip tip;       ///< as of the last frame
  Tip next_tip;  ///< of the frame that is being built
  bool show_panel = true;
  Snapshots snapshots;
  uint64_t snapshots_of = 0;        ///< number of the session that they are of
  bool show_snapshot = false;       ///< flipped: the snapshot in place of the live picture
  bool is_wiping = false;           ///< the snapshot on the left of the line
  float wipe = 0.5f;                ///< where the line is, in [0, 1] of the picture's area
  std::optional<vec2> wipe_handle;  ///< where the line was held by in the last frame
  bool show_inspector = false;
  bool show_histogram = false;
  PictureHistogram histogram;
  std::pair<uint64_t, uint64_t> histogram_of{0, 0};  ///< session and version of its picture
  PlaceTool tool = PlaceTool::none;
  bool tool_missed = false;            ///< the last click found nothing to work on
  std::array<char, 260> light_name{};  ///< in the box
  bool is_naming = false;              ///< it is being typed
  bool nudging = false;                ///< a light is being moved with the keyboard
  bool quit = false;
};

}  // namespace relume

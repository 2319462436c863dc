#pragma once

#include <imgui.h>

#include <optional>
#include <vector>

#include "viewer/panels/ui_state.h"
#include "viewer/session/session.h"

namespace relume {

/// What the tools over the picture work with.
struct PictureTools {
  UiState& ui;
  Session& session;
  ImDrawList& list;
  float font;
  vec2 mouse;

  float handle_radius() const { return 0.5f * font; }
  bool is_near_mouse(vec2 screen) const { return glm::distance(screen, mouse) <= 0.8f * font; }
  /// The selected light, or null.
  Light* selected_light() const;
  /// Where a world point is on the screen; nothing behind the eye.
  std::optional<vec2> screen_from_world(vec3 p_world) const;
};

/// What the selected light is aimed at: for spots the first surface on their axis, or the point of
/// it nearest to the scene's middle; otherwise that middle. World.
vec3 aim_point(const PictureTools& tools, const Light& light);

/// Takes hold of the aim or a cone of the selected spot when the mouse is over it; true then.
/// Items: "spot.aim", "spot.inner", "spot.outer".
bool start_spot_drag(const PictureTools& tools);
void continue_spot_drag(const PictureTools& tools);
void draw_spot(const PictureTools& tools);

/// Starts to place the selected light with the tool in use, at the mouse.
void start_placing(const PictureTools& tools);
void continue_placing(const PictureTools& tools);

/// The choice of tools over the picture, with what the one in use waits for. Items: "tool.move",
/// "tool.highlight", ...
void tool_bar(UiState& ui, const Session& session);

}  // namespace relume

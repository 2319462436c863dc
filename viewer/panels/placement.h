#pragma once

#include "core/math/vec.h"
#include "viewer/session/view_state.h"

namespace relume {

/// An axis-aligned rectangle on the screen, origin at the top left.
struct Rect {
  vec2 min{0};
  vec2 max{0};

  vec2 size() const { return max - min; }
  vec2 center() const { return 0.5f * (min + max); }
  bool contains(vec2 p) const { return p.x >= min.x && p.x < max.x && p.y >= min.y && p.y < max.y; }
};

/// How the parts of the window share it, in screen units. Every rectangle has a size >= 0.
struct Layout {
  Rect menu;  ///< along the top
  Rect picture;
  Rect panel;   ///< at the right; empty when hidden
  Rect status;  ///< along the bottom
};
Layout make_layout(vec2 window, float font_size, bool show_panel);

/// Where the picture lies: screen = origin + scale * film.
struct Placement {
  Rect area;        ///< the part of the screen that it may cover
  vec2 origin{0};   ///< screen position of the picture's top left corner
  float scale = 1;  ///< screen units per picture pixel, > 0

  vec2 screen_from_film(vec2 film_px) const { return origin + scale * film_px; }
  vec2 film_from_screen(vec2 screen) const { return (screen - origin) / scale; }
};

/// Fits a picture of `size_px` into `area` (view.zoom = 0), or shows it at view.zoom around
/// view.zoom_center_px. The origin is a whole number, so that at zoom 1 pixels meet pixels.
Placement place_picture(const Rect& area, vec2 size_px, const ViewState& view);

/// Multiplies the zoom by `factor`, within 1/16 .. 64, and keeps the picture position under
/// `screen` where it is.
void zoom_at(ViewState& view, const Placement& placement, vec2 screen, float factor);

/// Moves the picture by `delta` on the screen.
void pan_by(ViewState& view, const Placement& placement, vec2 delta);

}  // namespace relume

#include "viewer/panels/placement.h"

namespace relume {
namespace {

constexpr float panel_width_in_fonts = 22.5f;
constexpr float status_height_in_fonts = 1.9f;
constexpr float menu_height_in_fonts = 1.6f;
constexpr float smallest_zoom = 1.0f / 16;
constexpr float largest_zoom = 64;

}  // namespace

Layout make_layout(vec2 window, float font_size, bool show_panel) {
  const vec2 size = glm::max(window, vec2(1));
  const float wanted = show_panel ? std::floor(panel_width_in_fonts * font_size) : 0;
  const float split_x = size.x - std::min(wanted, std::floor(0.5f * size.x));
  const float split_y = std::max(0.0f, size.y - std::floor(status_height_in_fonts * font_size));
  const float top = std::min(std::floor(menu_height_in_fonts * font_size), split_y);
  return {.menu = {vec2(0), {size.x, top}},
          .picture = {{0, top}, {split_x, split_y}},
          .panel = {{split_x, top}, {size.x, split_y}},
          .status = {{0, split_y}, size}};
}

Placement place_picture(const Rect& area, vec2 size_px, const ViewState& view) {
  const vec2 room = glm::max(area.size(), vec2(1));
  const vec2 picture = glm::max(size_px, vec2(1));
  Placement placement{.area = area};
  if (view.zoom > 0) {
    placement.scale = view.zoom;
    placement.origin = glm::round(area.center() - view.zoom * view.zoom_center_px);
  } else {
    placement.scale = std::min(room.x / picture.x, room.y / picture.y);
    placement.origin = glm::round(area.center() - 0.5f * placement.scale * picture);
  }
  return placement;
}

void zoom_at(ViewState& view, const Placement& placement, vec2 screen, float factor) {
  const vec2 held_px = placement.film_from_screen(screen);
  view.zoom = std::clamp(placement.scale * factor, smallest_zoom, largest_zoom);
  view.zoom_center_px = held_px + (placement.area.center() - screen) / view.zoom;
}

void pan_by(ViewState& view, const Placement& placement, vec2 delta) {
  view.zoom = placement.scale;
  view.zoom_center_px = placement.film_from_screen(placement.area.center() - delta);
}

}  // namespace relume

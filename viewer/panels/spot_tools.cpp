#include <fmt/format.h>

#include "viewer/panels/picture_tools.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/light_motion.h"

namespace relume {
namespace {

constexpr int ring_steps = 64;
constexpr ImU32 shade_color = IM_COL32(0, 0, 0, 150);

/// The selected light when it is a spot.
Light* selected_spot(const PictureTools& tools) {
  Light* light = tools.selected_light();
  return light != nullptr && light->type == LightType::spot ? light : nullptr;
}

SpotCone cone_of(const PictureTools& tools, const Light& light) {
  const float distance = glm::distance(aim_point(tools, light), light.position);
  return make_spot_cone(light, distance, tools.session.info().bounds);
}

/// A cone is held by the point of its ring that is farthest from the ring's middle on the screen,
/// where a drag changes the angle most: on the right (side 1), or on the left (-1), so that the
/// inner and the outer cone's do not meet.
std::optional<vec2> ring_handle(const PictureTools& tools, const SpotCone& cone, float angle_deg,
                                float side) {
  const auto middle = tools.screen_from_world(cone_point(cone, 0, 0));
  if (!middle) return std::nullopt;
  std::optional<vec2> best;
  for (int i = 0; i < ring_steps; ++i) {
    const float turn = 2 * pi * static_cast<float>(i) / ring_steps;
    const auto screen = tools.screen_from_world(cone_point(cone, angle_deg, turn));
    if (!screen || side * (screen->x - middle->x) < 0) continue;
    const bool is_farther =
        !best || glm::distance(*screen, *middle) > glm::distance(*best, *middle);
    if (is_farther) best = screen;
  }
  return best;
}

void draw_ring(const PictureTools& tools, const SpotCone& cone, float angle_deg, ImU32 color) {
  std::optional<vec2> last;
  for (int i = 0; i <= ring_steps; ++i) {
    const float turn = 2 * pi * static_cast<float>(i) / ring_steps;
    const auto screen = tools.screen_from_world(cone_point(cone, angle_deg, turn));
    if (screen && last) {
      tools.list.AddLine(to_im(*last), to_im(*screen), shade_color, 0.22f * tools.font);
      tools.list.AddLine(to_im(*last), to_im(*screen), color, 0.09f * tools.font);
    }
    last = screen;
  }
}

void draw_grip(const PictureTools& tools, std::optional<vec2> screen, const char* item,
               bool is_held) {
  if (!screen) return;
  const float size = (is_held ? 0.36f : 0.3f) * tools.font;
  const vec2 reach(size);
  tools.list.AddRectFilled(to_im(*screen - reach - 1.0f), to_im(*screen + reach + 1.0f),
                           shade_color);
  tools.list.AddRectFilled(to_im(*screen - reach), to_im(*screen + reach), accent_color);
  tools.ui.items.note(item, {*screen - 2.0f, *screen + 2.0f});
}

void hold(const PictureTools& tools, Grip grip, const Light& light) {
  Drag& drag = tools.ui.drag;
  drag = {};
  drag.grip = grip;
  drag.light = tools.session.view().selected_light;
  drag.start_world = aim_point(tools, light);
  drag.start_screen = tools.mouse;
  drag.cone = cone_of(tools, light);
}

/// Where the mouse's ray meets the disc of the cone; nothing when it runs beside it.
std::optional<vec3> mouse_on_disc(const PictureTools& tools, const SpotCone& cone) {
  const CameraRays& rays = tools.session.rays();
  const vec3 direction = rays.direction(tools.ui.placement.film_from_screen(tools.mouse));
  const float slope = glm::dot(direction, cone.axis);
  const vec3 center = cone.apex + cone.distance * cone.axis;
  if (std::abs(slope) < 0.05f) return std::nullopt;
  const float t = glm::dot(center - rays.eye(), cone.axis) / slope;
  if (!(t > 0)) return std::nullopt;
  return rays.eye() + direction * t;
}

/// A disc seen from its edge is measured across the screen instead.
float cone_angle_at_mouse(const PictureTools& tools, const SpotCone& cone) {
  if (const auto p_world = mouse_on_disc(tools, cone)) return cone_angle_at(cone, *p_world);
  const CameraRays& rays = tools.session.rays();
  const vec3 center = cone.apex + cone.distance * cone.axis;
  const auto screen = tools.screen_from_world(center);
  if (!screen) return 0;
  const float world_per_px = rays.footprint_per_depth() * rays.project(center).depth;
  const float across =
      glm::distance(*screen, tools.mouse) / tools.ui.placement.scale * world_per_px;
  return std::atan2(across, cone.distance) * (180.0f / pi);
}

}  // namespace

bool start_spot_drag(const PictureTools& tools) {
  const Light* light = selected_spot(tools);
  if (light == nullptr) return false;
  const SpotCone cone = cone_of(tools, *light);
  const auto is_at = [&](std::optional<vec2> screen) {
    return screen && tools.is_near_mouse(*screen);
  };
  Grip grip = Grip::none;
  if (is_at(ring_handle(tools, cone, light->inner_angle_deg, -1))) grip = Grip::inner_cone;
  if (is_at(ring_handle(tools, cone, light->outer_angle_deg, 1))) grip = Grip::outer_cone;
  if (is_at(tools.screen_from_world(aim_point(tools, *light)))) grip = Grip::aim;
  if (grip == Grip::none) return false;
  hold(tools, grip, *light);
  return true;
}

void continue_spot_drag(const PictureTools& tools) {
  Light* light = selected_spot(tools);
  const Drag& drag = tools.ui.drag;
  if (light == nullptr || tools.mouse == drag.start_screen) return;
  if (drag.grip == Grip::aim) {
    const vec2 delta_px = (tools.mouse - drag.start_screen) / tools.ui.placement.scale;
    const vec3 aim = move_in_view_plane(tools.session.rays(), drag.start_world, delta_px);
    light->direction = normalize_or(aim - light->position, light->direction);
    return;
  }
  const float angle = cone_angle_at_mouse(tools, drag.cone);
  if (drag.grip == Grip::outer_cone) {
    light->outer_angle_deg = std::clamp(angle, min_spot_angle_deg, 90.0f);
    light->inner_angle_deg = std::min(light->inner_angle_deg, light->outer_angle_deg);
  } else {
    light->inner_angle_deg = std::clamp(angle, 0.0f, light->outer_angle_deg);
  }
}

void draw_spot(const PictureTools& tools) {
  const Light* light = selected_spot(tools);
  if (light == nullptr) return;
  const Grip held = tools.ui.drag.grip;
  const SpotCone cone = cone_of(tools, *light);
  const auto apex = tools.screen_from_world(light->position);
  const auto aim = tools.screen_from_world(aim_point(tools, *light));
  if (apex && aim) {
    tools.list.AddLine(to_im(*apex), to_im(*aim), shade_color, 0.2f * tools.font);
    tools.list.AddLine(to_im(*apex), to_im(*aim), IM_COL32(255, 176, 66, 150), 0.08f * tools.font);
  }
  draw_ring(tools, cone, light->inner_angle_deg, IM_COL32(255, 176, 66, 140));
  draw_ring(tools, cone, light->outer_angle_deg, accent_color);
  draw_grip(tools, ring_handle(tools, cone, light->inner_angle_deg, -1), "spot.inner",
            held == Grip::inner_cone);
  draw_grip(tools, ring_handle(tools, cone, light->outer_angle_deg, 1), "spot.outer",
            held == Grip::outer_cone);
  draw_grip(tools, aim, "spot.aim", held == Grip::aim);
}

}  // namespace relume

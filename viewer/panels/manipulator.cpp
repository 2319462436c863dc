#include "viewer/panels/manipulator.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "core/base/error.h"
#include "viewer/panels/picture_tools.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/light_motion.h"

namespace relume {
namespace {

/// The axes along which a light is moved: the world's, and the way to what it is aimed at.
constexpr size_t axis_count = 4;
constexpr std::array<vec3, 3> world_axes = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
constexpr std::array<const char*, axis_count> axis_names = {"x", "y", "z", "aim"};
constexpr std::array<ImU32, axis_count> axis_colors = {
    IM_COL32(240, 90, 80, 255), IM_COL32(110, 215, 100, 255), IM_COL32(95, 150, 255, 255),
    IM_COL32(235, 215, 120, 255)};
constexpr std::array<Grip, axis_count> axis_grips = {Grip::axis_x, Grip::axis_y, Grip::axis_z,
                                                     Grip::axis_aim};

/// A light's handle on the screen. A light in the picture moves with the pointer. One outside of it
/// or behind the camera may be so near to the eye that it would hardly move: it moves as something
/// at the camera's target does.
struct LightHandle {
  int light;
  vec3 p_world;
  vec3 measured_world;  ///< p_world, or the camera's target when outside
  vec2 screen;          ///< within the picture's area
  vec2 outward{0};  ///< unit, towards the light when it is outside; zero when it is in the picture
};

/// The far end of an axis of the selected light.
struct AxisTip {
  size_t axis;
  vec3 direction;  ///< unit, world
  vec2 screen;
};

/// How long an axis is on the screen when it lies in the view plane.
float axis_length(const PictureTools& m) {
  return 5 * m.font;
}

/// The unit direction on the screen, from the picture's middle, in which a light outside it lies.
vec2 outward_direction(const CameraRays& rays, vec3 p_world) {
  const vec3 v = normalize_or(p_world - rays.eye(), vec3(0));
  const vec2 side(glm::dot(v, rays.right()), -glm::dot(v, rays.up()));
  const float length = glm::length(side);
  return length > 1e-4f ? side / length : vec2(0, 1);
}

/// Where the ray from the middle of `area` leaves it, with room left for the axes.
vec2 edge_position(const PictureTools& m, const Rect& area, vec2 direction) {
  const vec2 size = area.size();
  const float margin = std::min(6 * m.font, 0.2f * std::min(size.x, size.y));
  const vec2 reach =
      glm::max(0.5f * size - margin, vec2(1)) / glm::max(glm::abs(direction), vec2(1e-6f));
  return area.center() + direction * std::min(reach.x, reach.y);
}

LightHandle find_handle(const PictureTools& m, int index) {
  const SessionInfo& info = m.session.info();
  const CameraRays& rays = m.session.rays();
  const Light& light = m.session.view().lights[static_cast<size_t>(index)];
  const vec3 p_world = light_handle(light, info.bounds);
  const CameraRays::Projection projection = rays.project(p_world);
  const vec2 screen = m.ui.placement.screen_from_film(projection.film_px);
  const Rect& area = m.ui.layout.picture;
  if (projection.depth > 0 && area.contains(screen))
    return {index, p_world, p_world, screen, vec2(0)};
  const vec2 outward = outward_direction(rays, p_world);
  return {index, p_world, info.camera.target, edge_position(m, area, outward), outward};
}

/// How long an axis is in the world so that it measures axis_length() on the screen when it lies in
/// the view plane.
float axis_unit(const PictureTools& m, vec3 p_world) {
  const CameraRays& rays = m.session.rays();
  const float world_per_px = rays.footprint_per_depth() * rays.project(p_world).depth;
  return world_per_px * axis_length(m) / m.ui.placement.scale;
}

/// What `axis`, axis_unit() long, measures on the screen at the handle; nothing when it ends behind
/// the eye.
std::optional<vec2> screen_axis(const PictureTools& m, const LightHandle& handle, vec3 axis) {
  const CameraRays& rays = m.session.rays();
  const vec3 from = handle.measured_world;
  const CameraRays::Projection end = rays.project(from + axis * axis_unit(m, from));
  if (!(end.depth > 0)) return std::nullopt;
  return (end.film_px - rays.project(from).film_px) * m.ui.placement.scale;
}

/// From the light away from what it is aimed at; zero for lights without a place.
vec3 aim_axis(const PictureTools& m, const LightHandle& handle) {
  const Light& light = m.session.view().lights[static_cast<size_t>(handle.light)];
  if (light.type == LightType::directional) return vec3(0);
  return normalize_or(light.position - aim_point(m, light), vec3(0));
}

std::vector<AxisTip> find_axis_tips(const PictureTools& m, const LightHandle& handle) {
  std::vector<AxisTip> tips;
  for (size_t axis = 0; axis < axis_count; ++axis) {
    const vec3 direction = axis < world_axes.size() ? world_axes[axis] : aim_axis(m, handle);
    const auto offset = screen_axis(m, handle, direction);
    // An axis that points at the eye cannot be dragged.
    if (!offset || !(glm::length(*offset) > 1.5f * m.handle_radius())) continue;
    const float shrink = std::min(1.0f, 1.5f * axis_length(m) / glm::length(*offset));
    tips.push_back({axis, direction, handle.screen + *offset * shrink});
  }
  return tips;
}

void draw_axes(const PictureTools& m, const LightHandle& handle, const std::vector<AxisTip>& tips) {
  for (const AxisTip& tip : tips) {
    const size_t axis = tip.axis;
    const bool held = m.ui.drag.grip == axis_grips[axis];
    m.list.AddLine(to_im(handle.screen), to_im(tip.screen), IM_COL32(0, 0, 0, 150), 0.3f * m.font);
    m.list.AddLine(to_im(handle.screen), to_im(tip.screen), axis_colors[axis],
                   (held ? 0.26f : 0.15f) * m.font);
    m.list.AddCircleFilled(to_im(tip.screen), 0.36f * m.font, axis_colors[axis], 20);
    const vec2 text = tip.screen + vec2(0.5f, -0.55f) * m.font;
    add_outlined_text(m.list, text, axis_colors[axis], axis_names[axis]);
    m.ui.items.note(fmt::format("axis.{}", axis_names[axis]),
                    {tip.screen - 2.0f, tip.screen + 2.0f});
  }
}

/// The way a spot or directional light points.
void draw_direction(const PictureTools& m, const LightHandle& handle, const Light& light) {
  if (light.type == LightType::point) return;
  const bool is_selected = m.session.view().selected_light == handle.light;
  if (light.type == LightType::spot && is_selected) return;  // draw_spot() shows more
  const auto offset = screen_axis(m, handle, normalize_or(light.direction, vec3(0, -1, 0)));
  if (!offset) return;
  const ImVec2 from = to_im(handle.screen);
  const ImVec2 to = to_im(handle.screen + *offset);
  m.list.AddLine(from, to, IM_COL32(0, 0, 0, 150), 0.3f * m.font);
  m.list.AddLine(from, to, accent_color, 0.12f * m.font);
}

/// An arrow head beside the handle that points to where the light is.
void draw_outward(const PictureTools& m, const LightHandle& handle, ImU32 color) {
  const vec2 across(-handle.outward.y, handle.outward.x);
  const vec2 base = handle.screen + handle.outward * (1.1f * m.font);
  m.list.AddTriangleFilled(to_im(base + handle.outward * (0.7f * m.font)),
                           to_im(base + across * (0.4f * m.font)),
                           to_im(base - across * (0.4f * m.font)), color);
}

void draw_handle(const PictureTools& m, const LightHandle& handle) {
  const ViewState& view = m.session.view();
  const Light& light = view.lights[static_cast<size_t>(handle.light)];
  const bool selected = view.selected_light == handle.light;
  const vec3 c = light.color / std::max(max_component(light.color), 1e-6f);
  const ImU32 fill = ImGui::ColorConvertFloat4ToU32(
      {std::sqrt(c.x), std::sqrt(c.y), std::sqrt(c.z), light.mute ? 0.25f : 1.0f});
  const float radius = m.handle_radius();
  draw_direction(m, handle, light);
  m.list.AddCircleFilled(to_im(handle.screen), radius + 2, IM_COL32(0, 0, 0, 170), 24);
  m.list.AddCircleFilled(to_im(handle.screen), radius, fill, 24);
  if (selected) {
    m.list.AddCircle(to_im(handle.screen), radius + 0.22f * m.font, IM_COL32_WHITE, 24,
                     0.13f * m.font);
  }
  const std::string name = fmt::format("{} {}{}", handle.light + 1, printable(light.name, 40),
                                       handle.outward == vec2(0) ? "" : " (outside)");
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  const bool flip = handle.screen.x + width + 1.5f * m.font > m.ui.layout.picture.max.x;
  const vec2 text =
      handle.screen + vec2(flip ? -width - 0.9f * m.font : 0.9f * m.font, 0.3f * m.font);
  const ImU32 text_color = selected ? IM_COL32_WHITE : IM_COL32(200, 200, 200, 255);
  add_outlined_text(m.list, text, text_color, name);
  if (handle.outward != vec2(0)) draw_outward(m, handle, text_color);
  m.ui.items.note(fmt::format("handle.{}", handle.light + 1),
                  {handle.screen - 2.0f, handle.screen + 2.0f});
}

/// Takes hold of an axis of the selected light when the mouse is at its end; true then.
bool start_axis_drag(const PictureTools& m, const std::vector<LightHandle>& handles,
                     const std::vector<AxisTip>& tips) {
  for (const LightHandle& handle : handles) {
    if (handle.light != m.session.view().selected_light) continue;
    for (const AxisTip& tip : tips) {
      if (!m.is_near_mouse(tip.screen)) continue;
      Drag& drag = m.ui.drag;
      drag = {};
      drag.grip = axis_grips[tip.axis];
      drag.light = handle.light;
      drag.start_world = handle.p_world;
      drag.measured_world = handle.measured_world;
      drag.start_screen = m.mouse;
      drag.axis = tip.direction;
      return true;
    }
  }
  return false;
}

/// Takes hold of the line between snapshot and live picture when the mouse is at its handle.
bool start_wipe_drag(const PictureTools& m) {
  const auto handle = m.ui.wipe_handle;
  if (!handle || !m.is_near_mouse(*handle)) return false;
  m.ui.drag = {};
  m.ui.drag.grip = Grip::wipe;
  return true;
}

void start_drag(const PictureTools& m, const std::vector<LightHandle>& handles,
                const std::vector<AxisTip>& tips) {
  if (start_wipe_drag(m)) return;
  if (m.ui.tool != PlaceTool::none) return start_placing(m);
  if (start_spot_drag(m) || start_axis_drag(m, handles, tips)) return;
  const LightHandle* nearest = nullptr;
  for (const LightHandle& handle : handles) {
    if (!m.is_near_mouse(handle.screen)) continue;
    const bool nearer = nearest == nullptr || glm::distance(handle.screen, m.mouse) <
                                                  glm::distance(nearest->screen, m.mouse);
    if (nearer) nearest = &handle;
  }
  if (nearest == nullptr) return;
  m.session.view().selected_light = nearest->light;
  Drag& drag = m.ui.drag;
  drag = {};
  drag.grip = Grip::view_plane;
  drag.light = nearest->light;
  drag.start_world = nearest->p_world;
  drag.measured_world = nearest->measured_world;
  drag.start_screen = m.mouse;
}

void continue_move(const PictureTools& m) {
  ViewState& view = m.session.view();
  const Drag& drag = m.ui.drag;
  const vec2 delta_px = (m.mouse - drag.start_screen) / m.ui.placement.scale;
  // A press alone must not move the light by a rounding error.
  if (drag.light >= static_cast<int>(view.lights.size()) || delta_px == vec2(0)) return;
  const CameraRays& rays = m.session.rays();
  const vec3 from = drag.measured_world;
  const vec3 to = drag.grip == Grip::view_plane
                      ? move_in_view_plane(rays, from, delta_px)
                      : move_along_axis(rays, from, drag.axis, axis_unit(m, from), delta_px);
  const vec3 p_world = drag.start_world + (to - from);
  set_light_handle(view.lights[static_cast<size_t>(drag.light)], m.session.info().bounds, p_world);
}

void continue_drag(const PictureTools& m) {
  Drag& drag = m.ui.drag;
  switch (drag.grip) {
    case Grip::none:
      return;
    case Grip::pan:
      pan_by(m.session.view(), m.ui.placement, m.mouse - drag.start_screen);
      drag.start_screen = m.mouse;
      return;
    case Grip::wipe:
      m.ui.wipe = std::clamp(
          (m.mouse.x - m.ui.layout.picture.min.x) / std::max(1.0f, m.ui.layout.picture.size().x),
          0.0f, 1.0f);
      return;
    case Grip::aim:
    case Grip::inner_cone:
    case Grip::outer_cone:
      return continue_spot_drag(m);
    case Grip::place:
      return continue_placing(m);
    case Grip::view_plane:
    case Grip::axis_x:
    case Grip::axis_y:
    case Grip::axis_z:
    case Grip::axis_aim:
      return continue_move(m);
  }
}

void handle_mouse(const PictureTools& m, const std::vector<LightHandle>& handles,
                  const std::vector<AxisTip>& tips) {
  const ImGuiIO& io = ImGui::GetIO();
  Drag& drag = m.ui.drag;
  const bool over_picture = !io.WantCaptureMouse && m.ui.layout.picture.contains(m.mouse);
  if (drag.grip == Grip::none && over_picture) {
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) start_drag(m, handles, tips);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle)) {
      drag = {};
      drag.grip = Grip::pan;
      drag.start_screen = m.mouse;
    }
    if (io.MouseWheel != 0) {
      zoom_at(m.session.view(), m.ui.placement, m.mouse, std::exp2(0.25f * io.MouseWheel));
    }
  }
  if (drag.grip == Grip::none) return;
  if (ImGui::IsMousePosValid()) continue_drag(m);
  const ImGuiMouseButton held =
      drag.grip == Grip::pan ? ImGuiMouseButton_Middle : ImGuiMouseButton_Left;
  if (!ImGui::IsMouseDown(held)) drag = {};
}

}  // namespace

void light_manipulator(UiState& ui, Session& session) {
  const PictureTools m{ui, session, *ImGui::GetBackgroundDrawList(), ImGui::GetFontSize(),
                       from_im(ImGui::GetIO().MousePos)};
  const auto find_all = [&] {
    std::vector<LightHandle> handles;
    for (int i = 0; i < static_cast<int>(session.view().lights.size()); ++i) {
      handles.push_back(find_handle(m, i));
    }
    return handles;
  };
  const auto find_tips = [&](const std::vector<LightHandle>& handles) {
    for (const LightHandle& handle : handles) {
      if (handle.light == session.view().selected_light) return find_axis_tips(m, handle);
    }
    return std::vector<AxisTip>();
  };
  const std::vector<LightHandle> before = find_all();
  handle_mouse(m, before, find_tips(before));

  // Drawn where the mouse has just put them.
  const std::vector<LightHandle> handles = find_all();
  const std::vector<AxisTip> tips = find_tips(handles);
  m.list.PushClipRect(to_im(ui.layout.picture.min), to_im(ui.layout.picture.max), true);
  draw_spot(m);
  for (const LightHandle& handle : handles) {
    if (handle.light == session.view().selected_light) draw_axes(m, handle, tips);
  }
  for (const LightHandle& handle : handles) draw_handle(m, handle);
  m.list.PopClipRect();
}

}  // namespace relume

#include "viewer/panels/manipulator.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

#include "core/base/error.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/light_motion.h"

namespace relume {
namespace {

constexpr std::array<vec3, 3> axes = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
constexpr std::array<const char*, 3> axis_names = {"x", "y", "z"};
constexpr std::array<ImU32, 3> axis_colors = {
    IM_COL32(240, 90, 80, 255), IM_COL32(110, 215, 100, 255), IM_COL32(95, 150, 255, 255)};
constexpr std::array<Grip, 3> axis_grips = {Grip::axis_x, Grip::axis_y, Grip::axis_z};

/// A light's handle on the screen.
struct Handle {
  int light;
  vec3 p_world;
  vec2 screen;   ///< within the picture's area
  bool outside;  ///< the light itself is outside the area
};

/// The far end of an axis of the selected light.
struct AxisTip {
  int axis;
  vec2 screen;
};

struct Manipulator {
  UiState& ui;
  Session& session;
  ImDrawList& list;
  float font;
  vec2 mouse;

  float handle_radius() const { return 0.5f * font; }
  float axis_length() const { return 5 * font; }
};

std::optional<Handle> find_handle(const Manipulator& m, int index) {
  const Light& light = m.session.view().lights[static_cast<size_t>(index)];
  const vec3 p_world = light_handle(light, m.session.info().bounds);
  const CameraRays::Projection projection = m.session.rays().project(p_world);
  if (!(projection.depth > 0) || !is_finite(projection.film_px)) return std::nullopt;
  const vec2 screen = m.ui.placement.screen_from_film(projection.film_px);
  const Rect& area = m.ui.layout.picture;
  const float margin = 1.2f * m.font;
  const vec2 shown =
      glm::clamp(screen, area.min + margin, glm::max(area.max - margin, area.min + margin));
  return Handle{index, p_world, shown, shown != screen};
}

/// How long an axis is in the world so that it measures axis_length() on the screen when it lies in
/// the view plane.
float axis_unit(const Manipulator& m, vec3 p_world) {
  const CameraRays& rays = m.session.rays();
  const float world_per_px = rays.footprint_per_depth() * rays.project(p_world).depth;
  return world_per_px * m.axis_length() / m.ui.placement.scale;
}

std::vector<AxisTip> find_axis_tips(const Manipulator& m, const Handle& handle) {
  std::vector<AxisTip> tips;
  const CameraRays& rays = m.session.rays();
  const float unit = axis_unit(m, handle.p_world);
  const vec2 origin = rays.project(handle.p_world).film_px;
  for (int axis = 0; axis < 3; ++axis) {
    const auto end = rays.project(handle.p_world + axes[static_cast<size_t>(axis)] * unit);
    const vec2 offset = (end.film_px - origin) * m.ui.placement.scale;
    const float length = glm::length(offset);
    // An axis that points at the eye cannot be dragged; one that leans far forward is drawn
    // shorter.
    if (!(end.depth > 0) || !(length > 1.5f * m.handle_radius())) continue;
    const vec2 tip = handle.screen + offset * std::min(1.0f, 1.5f * m.axis_length() / length);
    tips.push_back({axis, tip});
  }
  return tips;
}

void draw_axes(const Manipulator& m, const Handle& handle, const std::vector<AxisTip>& tips) {
  for (const AxisTip& tip : tips) {
    const size_t axis = static_cast<size_t>(tip.axis);
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

void draw_direction(const Manipulator& m, const Handle& handle, const Light& light) {
  if (light.type == LightType::point) return;
  const vec3 direction = normalize_or(light.direction, vec3(0, -1, 0));
  const CameraRays& rays = m.session.rays();
  const auto end = rays.project(handle.p_world + direction * axis_unit(m, handle.p_world));
  if (!(end.depth > 0)) return;
  const vec2 offset = (end.film_px - rays.project(handle.p_world).film_px) * m.ui.placement.scale;
  m.list.AddLine(to_im(handle.screen), to_im(handle.screen + offset), IM_COL32(0, 0, 0, 150),
                 0.3f * m.font);
  m.list.AddLine(to_im(handle.screen), to_im(handle.screen + offset), accent_color, 0.12f * m.font);
}

void draw_handle(const Manipulator& m, const Handle& handle) {
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
                                       handle.outside ? " (outside)" : "");
  const float width = ImGui::CalcTextSize(name.c_str()).x;
  const bool flip = handle.screen.x + width + 1.5f * m.font > m.ui.layout.picture.max.x;
  const vec2 text =
      handle.screen + vec2(flip ? -width - 0.9f * m.font : 0.9f * m.font, 0.3f * m.font);
  add_outlined_text(m.list, text, selected ? IM_COL32_WHITE : IM_COL32(200, 200, 200, 255), name);
  m.ui.items.note(fmt::format("handle.{}", handle.light + 1),
                  {handle.screen - 2.0f, handle.screen + 2.0f});
}

void start_drag(const Manipulator& m, const std::vector<Handle>& handles,
                const std::vector<AxisTip>& tips) {
  ViewState& view = m.session.view();
  const auto near_mouse = [&](vec2 p) { return glm::distance(p, m.mouse) <= 0.8f * m.font; };
  for (const Handle& handle : handles) {
    if (handle.light != view.selected_light) continue;
    for (const AxisTip& tip : tips) {
      if (!near_mouse(tip.screen)) continue;
      const Grip grip = axis_grips[static_cast<size_t>(tip.axis)];
      m.ui.drag = {grip, handle.light, handle.p_world, m.mouse};
      return;
    }
  }
  const Handle* nearest = nullptr;
  for (const Handle& handle : handles) {
    if (!near_mouse(handle.screen)) continue;
    const bool nearer = nearest == nullptr || glm::distance(handle.screen, m.mouse) <
                                                  glm::distance(nearest->screen, m.mouse);
    if (nearer) nearest = &handle;
  }
  if (nearest == nullptr) return;
  view.selected_light = nearest->light;
  m.ui.drag = {Grip::view_plane, nearest->light, nearest->p_world, m.mouse};
}

void continue_drag(const Manipulator& m) {
  ViewState& view = m.session.view();
  Drag& drag = m.ui.drag;
  if (drag.grip == Grip::pan) {
    pan_by(view, m.ui.placement, m.mouse - drag.start_screen);
    drag.start_screen = m.mouse;
    return;
  }
  const vec2 delta_px = (m.mouse - drag.start_screen) / m.ui.placement.scale;
  // A press alone must not move the light by a rounding error.
  if (drag.light >= static_cast<int>(view.lights.size()) || delta_px == vec2(0)) return;
  const CameraRays& rays = m.session.rays();
  vec3 p_world = drag.start_world;
  if (drag.grip == Grip::view_plane) {
    p_world = move_in_view_plane(rays, p_world, delta_px);
  } else {
    const int axis = static_cast<int>(drag.grip) - static_cast<int>(Grip::axis_x);
    p_world = move_along_axis(rays, p_world, axes[static_cast<size_t>(axis)], axis_unit(m, p_world),
                              delta_px);
  }
  set_light_handle(view.lights[static_cast<size_t>(drag.light)], m.session.info().bounds, p_world);
}

void handle_mouse(const Manipulator& m, const std::vector<Handle>& handles,
                  const std::vector<AxisTip>& tips) {
  const ImGuiIO& io = ImGui::GetIO();
  Drag& drag = m.ui.drag;
  const bool over_picture = !io.WantCaptureMouse && m.ui.layout.picture.contains(m.mouse);
  if (drag.grip == Grip::none && over_picture) {
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Left)) start_drag(m, handles, tips);
    if (ImGui::IsMouseClicked(ImGuiMouseButton_Middle))
      drag = {.grip = Grip::pan, .start_screen = m.mouse};
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
  const Manipulator m{ui, session, *ImGui::GetBackgroundDrawList(), ImGui::GetFontSize(),
                      from_im(ImGui::GetIO().MousePos)};
  const auto find_all = [&] {
    std::vector<Handle> handles;
    for (int i = 0; i < static_cast<int>(session.view().lights.size()); ++i) {
      if (const auto handle = find_handle(m, i)) handles.push_back(*handle);
    }
    return handles;
  };
  const auto find_tips = [&](const std::vector<Handle>& handles) {
    for (const Handle& handle : handles) {
      if (handle.light == session.view().selected_light) return find_axis_tips(m, handle);
    }
    return std::vector<AxisTip>();
  };
  const std::vector<Handle> before = find_all();
  handle_mouse(m, before, find_tips(before));

  // Drawn where the mouse has just put them.
  const std::vector<Handle> handles = find_all();
  const std::vector<AxisTip> tips = find_tips(handles);
  m.list.PushClipRect(to_im(ui.layout.picture.min), to_im(ui.layout.picture.max), true);
  for (const Handle& handle : handles) {
    if (handle.light == session.view().selected_light) draw_axes(m, handle, tips);
  }
  for (const Handle& handle : handles) draw_handle(m, handle);
  m.list.PopClipRect();
}

}  // namespace relume

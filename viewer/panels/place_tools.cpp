#include <fmt/format.h>

#include "core/base/error.h"
#include "viewer/panels/picture_tools.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

std::optional<SurfacePoint> surface_at_mouse(const PictureTools& tools) {
  const Tracer* tracer = tools.session.tracer();
  if (tracer == nullptr) return std::nullopt;
  return find_surface(*tracer, tools.session.rays(),
                      tools.ui.placement.film_from_screen(tools.mouse));
}

/// What a click will do.
std::string tool_hint(PlaceTool tool, const std::string& light, bool missed) {
  switch (tool) {
    case PlaceTool::highlight:
      return fmt::format("click where the highlight of {} shall be;  esc leaves", light);
    case PlaceTool::diffuse:
      return fmt::format("click what {} shall light most;  esc leaves", light);
    case PlaceTool::rim:
      return fmt::format("click where {} shall graze from behind;  esc leaves", light);
    case PlaceTool::shadow:
      return missed ? fmt::format("no shadow of {} there: press inside of one", light)
                    : fmt::format("drag a shadow of {};  esc leaves", light);
    case PlaceTool::none:
      break;
  }
  return {};
}

}  // namespace

Light* PictureTools::selected_light() const {
  ViewState& view = session.view();
  const bool exists =
      view.selected_light >= 0 && view.selected_light < static_cast<int>(view.lights.size());
  return exists ? &view.lights[static_cast<size_t>(view.selected_light)] : nullptr;
}

std::optional<vec2> PictureTools::screen_from_world(vec3 p_world) const {
  const CameraRays::Projection projection = session.rays().project(p_world);
  if (!(projection.depth > 0)) return std::nullopt;
  return ui.placement.screen_from_film(projection.film_px);
}

vec3 aim_point(const PictureTools& tools, const Light& light) {
  const Bounds& bounds = tools.session.info().bounds;
  if (light.type != LightType::spot) return bounds.center();
  const vec3 axis = normalize_or(light.direction, vec3(0, -1, 0));
  if (const Tracer* tracer = tools.session.tracer()) {
    if (const auto surface = tracer->intersect({.origin = light.position, .direction = axis})) {
      return surface->position;
    }
  }
  const float along = glm::dot(bounds.center() - light.position, axis);
  return light.position + axis * std::max(along, 0.2f * std::max(bounds.radius(), 1e-6f));
}

void start_placing(const PictureTools& tools) {
  const Light* light = tools.selected_light();
  const auto surface = surface_at_mouse(tools);
  tools.ui.tool_missed = true;
  if (light == nullptr || !surface) return;
  Drag drag;
  drag.light = tools.session.view().selected_light;
  drag.start_screen = tools.mouse;
  if (tools.ui.tool == PlaceTool::shadow) {
    const auto grip = grab_shadow(*tools.session.tracer(), *surface, *light);
    if (!grip) return;  // the light is seen from here: there is no shadow to drag
    drag.shadow = *grip;
  }
  drag.grip = Grip::place;
  tools.ui.drag = drag;
  tools.ui.tool_missed = false;
}

void continue_placing(const PictureTools& tools) {
  Light* light = tools.selected_light();
  const Drag& drag = tools.ui.drag;
  const auto surface = surface_at_mouse(tools);
  if (light == nullptr || !surface) return;
  if (tools.ui.tool != PlaceTool::shadow) {
    place_light(*light, tools.ui.tool, *surface, tools.session.rays().eye(),
                tools.session.info().bounds);
  } else if (tools.mouse != drag.start_screen) {
    drag_shadow(*light, drag.shadow, surface->position);
  }
}

void tool_bar(UiState& ui, const Session& session) {
  const ViewState& view = session.view();
  const bool has_light =
      view.selected_light >= 0 && view.selected_light < static_cast<int>(view.lights.size());
  if (session.tracer() == nullptr || !has_light) {
    ui.tool = PlaceTool::none;
    return;
  }
  const float font = ImGui::GetFontSize();
  const Rect& area = ui.layout.picture;
  const vec2 size(std::min(29 * font, area.size().x), 2.1f * font);
  const vec2 corner(std::round(area.center().x - 0.5f * size.x), area.max.y - size.y - 0.6f * font);
  if (size.y > area.size().y) return;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0.35f * font, 0.3f * font});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 0.3f * font);
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.1f, 0.1f, 0.1f, 0.85f));
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0.1f * font, ImGui::GetStyle().FramePadding.y});
  begin_fixed_window("tools", {corner, corner + size});
  choose(ui, "tool", place_tool_labels, ui.tool);
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(3);
  const Light& light = view.lights[static_cast<size_t>(view.selected_light)];
  const std::string hint = tool_hint(ui.tool, printable(light.name, 40), ui.tool_missed);
  const float width = ImGui::CalcTextSize(hint.c_str()).x;
  add_outlined_text(*ImGui::GetBackgroundDrawList(),
                    {std::round(area.center().x - 0.5f * width), corner.y - 1.5f * font},
                    accent_color, hint);
}

}  // namespace relume

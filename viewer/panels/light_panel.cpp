#include "viewer/panels/light_panel.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

constexpr float smallest_stops = -16;
constexpr float largest_stops = 24;

/// The light's hue at full brightness, as a dot is drawn.
ImU32 swatch_color(const Light& light) {
  const vec3 c = light.color / std::max(max_component(light.color), 1e-6f);
  return ImGui::ColorConvertFloat4ToU32({std::sqrt(c.x), std::sqrt(c.y), std::sqrt(c.z), 1});
}

void light_row(UiState& ui, ViewState& view, int index) {
  Light& light = view.lights[static_cast<size_t>(index)];
  const std::string item = fmt::format("lights.{}", index + 1);
  const float height = ImGui::GetFrameHeight();
  const float mute_width = 3.4f * ImGui::GetFontSize();
  const float gap = ImGui::GetStyle().ItemSpacing.x;
  const float name_width = std::max(1.0f, ImGui::GetContentRegionAvail().x - mute_width - gap);
  ImGui::PushID(index);
  const vec2 corner = from_im(ImGui::GetCursorScreenPos());
  const std::string label = fmt::format("        {}  {}", index + 1, printable(light.name, 40));
  ImGui::PushStyleVar(ImGuiStyleVar_SelectableTextAlign, {0, 0.5f});
  ImGui::PushStyleColor(
      ImGuiCol_Text, ImGui::GetStyleColorVec4(light.mute ? ImGuiCol_TextDisabled : ImGuiCol_Text));
  if (ImGui::Selectable(label.c_str(), view.selected_light == index, 0, {name_width, height})) {
    view.selected_light = index;
  }
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  note_item(ui, item);
  const vec2 dot = corner + vec2(0.85f, 0.5f) * height;
  ImGui::GetWindowDrawList()->AddCircleFilled(to_im(dot), 0.26f * height, swatch_color(light), 20);
  ImGui::SameLine(0, gap);
  if (segment_button("mute", light.mute, true, mute_width)) light.mute = !light.mute;
  note_item(ui, item + ".mute");
  ImGui::PopID();
}

void gain_row(UiState& ui, Light& light) {
  row_label("gain");
  float stops = std::clamp(std::log2(std::max(light.gain, 1e-30f)), smallest_stops, largest_stops);
  const std::string format = fmt::format("%+.2f stops  (x{:.4g})", light.gain);
  if (ImGui::DragFloat("##gain", &stops, 0.02f, smallest_stops, largest_stops, format.c_str(),
                       ImGuiSliderFlags_AlwaysClamp) &&
      is_finite(stops)) {
    light.gain = std::exp2(stops);
  }
  note_item(ui, "light.gain");
}

void vector_row(UiState& ui, const char* label, const std::string& item, float speed, vec3& value) {
  row_label(label);
  vec3 edited = value;
  const bool changed = ImGui::DragFloat3(("##" + item).c_str(), &edited.x, speed, 0, 0, "%.3f");
  note_item(ui, item);
  if (changed && is_finite(edited)) value = edited;
}

void cone_rows(UiState& ui, Light& light) {
  row_label("cone inner");
  ImGui::SliderFloat("##inner", &light.inner_angle_deg, 0, 90, "%.1f deg",
                     ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "light.inner");
  if (ImGui::IsItemEdited()) {
    light.outer_angle_deg = std::max(light.outer_angle_deg, light.inner_angle_deg);
  }
  row_label("cone outer");
  ImGui::SliderFloat("##outer", &light.outer_angle_deg, min_spot_angle_deg, 90, "%.1f deg",
                     ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "light.outer");
  light.outer_angle_deg = std::max(light.outer_angle_deg, min_spot_angle_deg);
  light.inner_angle_deg = std::min(light.inner_angle_deg, light.outer_angle_deg);
}

void color_row(UiState& ui, Light& light) {
  row_label("colour");
  vec3 edited = light.color;
  const bool changed =
      ImGui::ColorEdit3("##color", &edited.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
  note_item(ui, "light.color");
  if (changed && is_finite(edited)) light.color = glm::max(edited, vec3(0));
}

void selected_light(UiState& ui, const SessionInfo& info, Light& light) {
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(accent_color), "%s",
                     printable(light.name, 40).c_str());
  const bool was_point = light.type == LightType::point;
  if (choose(ui, "light.type", light_type_labels, light.type) && was_point) {
    // A point light's direction says nothing: start by aiming at the scene.
    light.direction = normalize_or(info.bounds.center() - light.position, light.direction);
  }
  gain_row(ui, light);
  color_row(ui, light);
  if (light.type != LightType::directional) {
    vector_row(ui, "position", "light.position", 0.005f * std::max(info.bounds.radius(), 1e-3f),
               light.position);
  }
  if (light.type != LightType::point) {
    vec3 direction = light.direction;
    vector_row(ui, "direction", "light.direction", 0.01f, direction);
    if (glm::length(dvec3(direction)) > 0) light.direction = direction;
  }
  if (light.type == LightType::spot) cone_rows(ui, light);
  if (light.type != LightType::directional) {
    ImGui::Checkbox("inverse-square falloff", &light.falloff);
    note_item(ui, "light.falloff");
  }
  ImGui::Checkbox("casts shadow", &light.casts_shadow);
  note_item(ui, "light.casts_shadow");
}

}  // namespace

void light_panel(UiState& ui, Session& session) {
  ViewState& view = session.view();
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "LIGHTS");
  const int count = static_cast<int>(view.lights.size());
  if (count == 0) ImGui::TextDisabled("The scene has no lights.");
  for (int i = 0; i < count; ++i) light_row(ui, view, i);
  if (view.selected_light < 0 || view.selected_light >= count) return;
  ImGui::Spacing();
  ImGui::Separator();
  ImGui::Spacing();
  selected_light(ui, session.info(), view.lights[static_cast<size_t>(view.selected_light)]);
}

}  // namespace relume

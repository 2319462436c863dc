#include "viewer/panels/light_panel.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/scene/limits.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/light_color.h"
#include "viewer/session/light_edits.h"

namespace relume {
namespace {

constexpr float smallest_stops = -16;
constexpr float largest_stops = 24;

/// The light's hue at full brightness, as a dot is drawn.
ImU32 swatch_color(const Light& light) {
  const vec3 c = light.color / std::max(max_component(light.color), 1e-6f);
  return ImGui::ColorConvertFloat4ToU32({std::sqrt(c.x), std::sqrt(c.y), std::sqrt(c.z), 1});
}

/// The light's colour, number and name; a click selects it.
void name_cell(UiState& ui, ViewState& view, int index, float width) {
  const Light& light = view.lights[static_cast<size_t>(index)];
  const float height = ImGui::GetFrameHeight();
  const bool is_dark = light.mute || (!view.solo_lights.empty() && !is_solo(view, index));
  const vec2 corner = from_im(ImGui::GetCursorScreenPos());
  const std::string label = fmt::format("       {}  {}", index + 1, printable(light.name, 40));
  ImGui::PushStyleVar(ImGuiStyleVar_SelectableTextAlign, {0, 0.5f});
  ImGui::PushStyleColor(ImGuiCol_Text,
                        ImGui::GetStyleColorVec4(is_dark ? ImGuiCol_TextDisabled : ImGuiCol_Text));
  if (ImGui::Selectable(label.c_str(), view.selected_light == index, 0, {width, height})) {
    view.selected_light = index;
  }
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  note_item(ui, fmt::format("lights.{}", index + 1));
  const vec2 dot = corner + vec2(0.6f, 0.5f) * height;
  ImGui::GetWindowDrawList()->AddCircleFilled(to_im(dot), 0.26f * height, swatch_color(light), 20);
}

void light_row(UiState& ui, ViewState& view, int index) {
  const std::string item = fmt::format("lights.{}", index + 1);
  const float button = ImGui::GetFrameHeight() + 0.2f * ImGui::GetFontSize();
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float room = ImGui::GetContentRegionAvail().x - 2 * (button + gap);
  ImGui::PushID(index);
  name_cell(ui, view, index, std::max(1.0f, room));
  ImGui::SameLine(0, gap);
  if (segment_button("S", is_solo(view, index), true, button)) toggle_solo(view, index);
  note_item(ui, item + ".solo");
  ImGui::SameLine(0, gap);
  Light& light = view.lights[static_cast<size_t>(index)];
  if (segment_button("M", light.mute, true, button)) light.mute = !light.mute;
  note_item(ui, item + ".mute");
  ImGui::PopID();
}

void name_row(UiState& ui, ViewState& view) {
  Light& light = view.lights[static_cast<size_t>(view.selected_light)];
  row_label("name");
  if (!ui.is_naming) {
    ui.light_name.fill(0);
    light.name.copy(ui.light_name.data(), ui.light_name.size() - 1);
  }
  ImGui::InputText("##name", ui.light_name.data(), ui.light_name.size());
  note_item(ui, "light.name");
  if (ImGui::IsItemDeactivatedAfterEdit()) {
    rename_light(view, view.selected_light, ui.light_name.data());
  }
  ui.is_naming = ImGui::IsItemActive();
}

/// Sets the colour's hue and saturation to those of a black body.
void temperature_row(UiState& ui, Light& light) {
  row_label("kelvin");
  const auto kelvin = temperature_of_color(light.color);
  float edited = kelvin.value_or(6500);
  if (ImGui::SliderFloat("##kelvin", &edited, min_temperature_k, max_temperature_k,
                         kelvin ? "%.0f K" : "not a white",
                         ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic) &&
      is_finite(edited)) {
    const bool is_black = !(max_component(light.color) > 0);
    light.color = color_of_temperature(edited, is_black ? vec3(1) : light.color);
  }
  note_item(ui, "light.kelvin");
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

/// Both half angles beside each other.
void cone_row(UiState& ui, Light& light) {
  row_label("cone");
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float width = 0.5f * (ImGui::GetContentRegionAvail().x - gap);
  ImGui::SetNextItemWidth(width);
  ImGui::SliderFloat("##inner", &light.inner_angle_deg, 0, 90, "in %.1f deg",
                     ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "light.inner");
  if (ImGui::IsItemEdited()) {
    light.outer_angle_deg = std::max(light.outer_angle_deg, light.inner_angle_deg);
  }
  ImGui::SameLine(0, gap);
  ImGui::SetNextItemWidth(width);
  ImGui::SliderFloat("##outer", &light.outer_angle_deg, min_spot_angle_deg, 90, "out %.1f deg",
                     ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "light.outer");
  if (ImGui::IsItemEdited()) {
    light.inner_angle_deg = std::min(light.inner_angle_deg, light.outer_angle_deg);
  }
}

void color_row(UiState& ui, Light& light) {
  row_label("colour");
  vec3 edited = light.color;
  const bool changed =
      ImGui::ColorEdit3("##color", &edited.x, ImGuiColorEditFlags_Float | ImGuiColorEditFlags_HDR);
  note_item(ui, "light.color");
  if (changed && is_finite(edited)) light.color = glm::max(edited, vec3(0));
}

/// Where the light ends; 0 = nowhere.
void range_row(UiState& ui, const SessionInfo& info, Light& light) {
  row_label("ends at");
  ImGui::DragFloat("##range", &light.range, 0.01f * std::max(info.bounds.radius(), 1e-3f), 0, 1e15f,
                   light.range > 0 ? "%.3f" : "nowhere", ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "light.range");
}

void geometry_rows(UiState& ui, const SessionInfo& info, Light& light) {
  if (light.type != LightType::directional) {
    vector_row(ui, "position", "light.position", 0.005f * std::max(info.bounds.radius(), 1e-3f),
               light.position);
  }
  if (light.type != LightType::point) {
    vector_row(ui, "direction", "light.direction", 0.01f, light.direction);
  }
  if (light.type == LightType::spot) cone_row(ui, light);
  ImGui::Checkbox("casts shadow", &light.casts_shadow);
  note_item(ui, "light.casts_shadow");
  if (light.type == LightType::directional) return;
  ImGui::SameLine(0.5f * ImGui::GetWindowContentRegionMax().x);
  ImGui::Checkbox("falls off", &light.falloff);
  note_item(ui, "light.falloff");
  if (light.falloff) range_row(ui, info, light);
}

void selected_light(UiState& ui, Session& session) {
  ViewState& view = session.view();
  const SessionInfo& info = session.info();
  Light& light = view.lights[static_cast<size_t>(view.selected_light)];
  const Light before = light;
  name_row(ui, view);
  LightType type = light.type;
  if (choose(ui, "light.type", light_type_labels, type)) set_light_type(light, type, info.bounds);
  gain_row(ui, light);
  color_row(ui, light);
  temperature_row(ui, light);
  geometry_rows(ui, info, light);
  limit_light(light, before);
}

/// The heading, with buttons for the list itself.
void list_heading(UiState& ui, Session& session) {
  ViewState& view = session.view();
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "LIGHTS");
  const float width = 4 * ImGui::GetFontSize();
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const bool has_light = view.selected_light >= 0;
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - 3 * width - 2 * gap);
  if (segment_button("add", false, view.lights.size() < max_lights, width)) {
    add_light(view, session.info().bounds, session.info().camera);
  }
  note_item(ui, "lights.add");
  ImGui::SameLine(0, gap);
  if (segment_button("copy", false, has_light, width)) duplicate_light(view);
  note_item(ui, "lights.copy");
  ImGui::SameLine(0, gap);
  if (segment_button("delete", false, has_light, width)) delete_light(view);
  note_item(ui, "lights.delete");
}

}  // namespace

void light_panel(UiState& ui, Session& session) {
  ViewState& view = session.view();
  list_heading(ui, session);
  const int count = static_cast<int>(view.lights.size());
  if (count == 0) ImGui::TextDisabled("No lights: add one.");
  constexpr int rows_shown = 8;
  const float row = ImGui::GetFrameHeightWithSpacing();
  // A long list scrolls by itself, so that the selected light's values stay in reach.
  if (count > rows_shown) ImGui::BeginChild("lights", {0, rows_shown * row});
  for (int i = 0; i < count; ++i) light_row(ui, view, i);
  if (count > rows_shown) ImGui::EndChild();
  if (view.selected_light < 0 || view.selected_light >= count) return;
  ImGui::Separator();
  selected_light(ui, session);
}

}  // namespace relume

#include "viewer/panels/widgets.h"

#include <filesystem>

#include "viewer/panels/tips.h"

namespace relume {
namespace {

constexpr float font_px = 15;
constexpr const char* font_file = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

ImVec4 gray(float level, float alpha = 1) {
  return {level, level, level, alpha};
}

void set_colors(ImGuiStyle& style) {
  ImGui::StyleColorsDark(&style);
  const ImVec4 accent = ImGui::ColorConvertU32ToFloat4(accent_color);
  ImVec4* colors = style.Colors;
  colors[ImGuiCol_Text] = gray(0.88f);
  colors[ImGuiCol_TextDisabled] = gray(0.48f);
  colors[ImGuiCol_WindowBg] = gray(0.145f);
  colors[ImGuiCol_PopupBg] = gray(0.11f, 0.98f);
  colors[ImGuiCol_Border] = gray(0.27f);
  colors[ImGuiCol_FrameBg] = gray(0.22f);
  colors[ImGuiCol_FrameBgHovered] = gray(0.28f);
  colors[ImGuiCol_FrameBgActive] = gray(0.32f);
  colors[ImGuiCol_Button] = gray(0.25f);
  colors[ImGuiCol_ButtonHovered] = gray(0.33f);
  colors[ImGuiCol_ButtonActive] = gray(0.4f);
  colors[ImGuiCol_Header] = gray(0.3f);
  colors[ImGuiCol_HeaderHovered] = gray(0.35f);
  colors[ImGuiCol_HeaderActive] = gray(0.4f);
  colors[ImGuiCol_SliderGrab] = gray(0.4f);
  colors[ImGuiCol_SliderGrabActive] = gray(0.5f);
  colors[ImGuiCol_CheckMark] = accent;
  colors[ImGuiCol_Separator] = gray(0.27f);
}

}  // namespace

void apply_theme(float scale) {
  ImGuiIO& io = ImGui::GetIO();
  ImGuiStyle& style = ImGui::GetStyle();
  set_colors(style);
  style.WindowRounding = 0;
  style.WindowBorderSize = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowPadding = {12, 10};
  style.FramePadding = {6, 3};
  style.ItemSpacing = {8, 4};
  style.ItemInnerSpacing = {4, 4};
  style.ScaleAllSizes(scale);
  std::error_code no_file;
  if (std::filesystem::is_regular_file(font_file, no_file)) {
    io.Fonts->AddFontFromFileTTF(font_file, std::round(font_px * scale));
  } else {
    ImFontConfig config;
    config.SizePixels = std::round(13 * scale);
    io.Fonts->AddFontDefault(&config);
  }
}

namespace {

/// How long the pointer stays before a tip comes.
constexpr float tip_delay_s = 0.6f;
/// At most so much of it in one frame: the window sleeps in between.
constexpr float tip_step_s = 0.3f;

void show_tip(UiState& ui, std::string_view name) {
  const std::string_view tip = tip_of(name);
  if (tip.empty() || ImGui::IsAnyMouseDown()) return;
  ui.next_tip.seconds = ui.tip.item == name ? ui.tip.seconds : 0;
  ui.next_tip.seconds += std::min(ImGui::GetIO().DeltaTime, tip_step_s);
  ui.next_tip.item = name;
  if (ui.next_tip.seconds < tip_delay_s) return;
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(20 * ImGui::GetFontSize());
  ImGui::TextUnformatted(tip.data(), tip.data() + tip.size());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

}  // namespace

void note_item(UiState& ui, std::string_view name) {
  if (!ImGui::IsItemVisible()) return;
  ui.items.note(name, {from_im(ImGui::GetItemRectMin()), from_im(ImGui::GetItemRectMax())});
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) show_tip(ui, name);
}

bool is_tip_due(const UiState& ui) {
  return !ui.next_tip.item.empty() && ui.next_tip.seconds < tip_delay_s;
}

void row_label(const char* label) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(label);
  ImGui::SameLine(6.2f * ImGui::GetFontSize());
  ImGui::SetNextItemWidth(-1);
}

bool segment_button(const char* label, bool lit, bool enabled, float width) {
  ImGui::BeginDisabled(!enabled);
  if (lit) {
    for (const ImGuiCol part : {ImGuiCol_Button, ImGuiCol_ButtonHovered, ImGuiCol_ButtonActive}) {
      ImGui::PushStyleColor(part, lit_color);
    }
    ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(20, 20, 20, 255));
  }
  const bool clicked = ImGui::Button(label, {width, 0});
  if (lit) ImGui::PopStyleColor(4);
  ImGui::EndDisabled();
  return clicked;
}

void begin_fixed_window(const char* name, const Rect& rect) {
  ImGui::SetNextWindowPos(to_im(rect.min));
  ImGui::SetNextWindowSize(to_im(glm::max(rect.size(), vec2(1))));
  ImGui::Begin(name, nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoNav);
}

void add_outlined_text(ImDrawList& list, vec2 position, ImU32 color, const std::string& text) {
  constexpr ImU32 edge = IM_COL32(0, 0, 0, 170);
  for (const vec2 offset : {vec2(1, 0), vec2(-1, 0), vec2(0, 1), vec2(0, -1)}) {
    list.AddText(to_im(position + offset), edge, text.c_str());
  }
  list.AddText(to_im(position), color, text.c_str());
}

}  // namespace relume

#include "viewer/panels/keys.h"

#include <array>

#include "viewer/panels/widgets.h"

namespace relume {
namespace {

constexpr float exposure_step = 0.5f;

/// One shortcut; help and dispatch read the same table.
struct Shortcut {
  char key;
  const char* shown;
  const char* does;
  void (*act)(UiState& ui, Session& session);
};

void show(Session& session, ShownPicture shown) {
  if (!needs_reference(shown) || session.info().has_reference) session.view().shown = shown;
}

void mute_selected(Session& session) {
  ViewState& view = session.view();
  if (view.selected_light < 0 || view.selected_light >= static_cast<int>(view.lights.size()))
    return;
  Light& light = view.lights[static_cast<size_t>(view.selected_light)];
  light.mute = !light.mute;
}

void toggle_shadows(Session& session) {
  ShadowMethod& method = session.view().shadows;
  const bool on = method == ShadowMethod::none && session.info().can_trace;
  method = on ? ShadowMethod::ray : ShadowMethod::none;
}

constexpr std::array shortcuts = {
    Shortcut{'f', "f", "show the frame",
             [](UiState&, Session& session) { show(session, ShownPicture::frame); }},
    Shortcut{'r', "r", "show the reference: every sample, traced shadows",
             [](UiState&, Session& session) { show(session, ShownPicture::reference); }},
    Shortcut{'h', "h", "show the heatmap of the frame's error",
             [](UiState&, Session& session) { show(session, ShownPicture::heatmap); }},
    Shortcut{'e', "e", "show the predicted error",
             [](UiState&, Session& session) { show(session, ShownPicture::predicted); }},
    Shortcut{'k', "k", "show the records of each pixel",
             [](UiState&, Session& session) { show(session, ShownPicture::records); }},
    Shortcut{'+', "+", "half a stop brighter",
             [](UiState&, Session& session) { session.view().display.exposure += exposure_step; }},
    Shortcut{'=', nullptr, nullptr,
             [](UiState&, Session& session) { session.view().display.exposure += exposure_step; }},
    Shortcut{'-', "-", "half a stop darker",
             [](UiState&, Session& session) { session.view().display.exposure -= exposure_step; }},
    Shortcut{'m', "m", "mute the selected light",
             [](UiState&, Session& session) { mute_selected(session); }},
    Shortcut{'s', "s", "shadows on or off",
             [](UiState&, Session& session) { toggle_shadows(session); }},
    Shortcut{'z', "z", "fit the picture into the window",
             [](UiState&, Session& session) { session.view().zoom = 0; }},
    Shortcut{'p', "p", "hide or show the panel",
             [](UiState& ui, Session&) { ui.show_panel = !ui.show_panel; }},
    Shortcut{'?', "?", "this list", [](UiState& ui, Session&) { ui.show_help = !ui.show_help; }},
    Shortcut{'q', "q", "quit", [](UiState& ui, Session&) { ui.quit = true; }},
};

constexpr std::array<std::array<const char*, 2>, 4> gestures = {{
    {"1 - 9", "select a light"},
    {"drag", "move the light in the view plane, or along an axis by its end"},
    {"wheel", "zoom at the pointer"},
    {"middle drag", "move the picture"},
}};

void handle_key(ImWchar key, UiState& ui, Session& session) {
  ViewState& view = session.view();
  if (key >= '1' && key <= '9') {
    const int index = key - '1';
    if (index < static_cast<int>(view.lights.size())) view.selected_light = index;
  }
  for (const Shortcut& shortcut : shortcuts) {
    if (shortcut.key == static_cast<char>(key) && key < 128) shortcut.act(ui, session);
  }
}

void help_row(const char* key, const char* does) {
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(accent_color), "%s", key);
  ImGui::SameLine(8 * ImGui::GetFontSize());
  ImGui::TextUnformatted(does);
}

}  // namespace

void handle_keys(UiState& ui, Session& session) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return;
  for (const ImWchar key : io.InputQueueCharacters) handle_key(key, ui, session);
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) ui.show_help = false;
}

void help_window(UiState& ui) {
  if (!ui.show_help) return;
  const vec2 center = ui.layout.picture.center();
  ImGui::SetNextWindowPos(to_im(center), ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding,
                      {1.5f * ImGui::GetFontSize(), 1.2f * ImGui::GetFontSize()});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.08f, 0.08f, 0.08f, 0.94f));
  ImGui::Begin("keys", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoNav);
  for (const auto& gesture : gestures) help_row(gesture[0], gesture[1]);
  ImGui::Separator();
  for (const Shortcut& shortcut : shortcuts) {
    if (shortcut.shown != nullptr) help_row(shortcut.shown, shortcut.does);
  }
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

}  // namespace relume

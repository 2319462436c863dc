#include "viewer/panels/keys.h"

#include <array>

#include "viewer/panels/actions.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/light_motion.h"

namespace relume {
namespace {

constexpr float nudge_px = 4;      // of the film, for each press of an arrow key
constexpr float nudge_depth = 32;  // pixels' worth of depth, for page up and down

/// Of the window, for two columns of keys beside each other.
constexpr float least_width_in_fonts = 52;

struct Gesture {
  const char* keys;
  const char* does;
};

constexpr std::array gestures = {
    Gesture{"1 - 9", "Select a light"},
    Gesture{"arrows", "Move it in the view plane"},
    Gesture{"page up, down", "Move it away, nearer"},
    Gesture{"drag", "Move it, or by an axis' end along it"},
    Gesture{"wheel", "Zoom at the pointer"},
    Gesture{"middle drag", "Move the picture"},
    Gesture{"escape", "Close, leave a tool"},
};

bool is_pressed(const KeyChord& key) {
  const ImGuiIO& io = ImGui::GetIO();
  if (key.named >= 0) {
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key.named), false) && io.KeyShift == key.shift &&
           !io.KeyCtrl;
  }
  if (key.ctrl) {
    return io.KeyCtrl && io.KeyShift == key.shift && ImGui::IsKeyPressed(key.character, false);
  }
  if (io.KeyCtrl || io.KeyAlt) return false;
  for (const ImWchar typed : io.InputQueueCharacters) {
    // On most keyboards the plus needs Shift, the equals sign does not.
    const ImWchar meant = typed == '=' ? '+' : typed;
    if (meant == static_cast<ImWchar>(key.character)) return true;
  }
  return false;
}

void select_by_digit(ViewState& view) {
  for (const ImWchar typed : ImGui::GetIO().InputQueueCharacters) {
    const int index = static_cast<int>(typed) - '1';
    if (index >= 0 && index < 9 && index < static_cast<int>(view.lights.size())) {
      view.selected_light = index;
    }
  }
}

/// What the arrow keys ask for: pixels to the right and down, and pixels' worth of depth.
vec3 asked_motion() {
  const auto pressed = [](ImGuiKey key) {
    return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), true) ? 1.0f : 0.0f;
  };
  return {nudge_px * (pressed(ImGuiKey_RightArrow) - pressed(ImGuiKey_LeftArrow)),
          nudge_px * (pressed(ImGuiKey_DownArrow) - pressed(ImGuiKey_UpArrow)),
          nudge_depth * (pressed(ImGuiKey_PageUp) - pressed(ImGuiKey_PageDown))};
}

bool is_nudge_key_down() {
  for (const ImGuiKey key : {ImGuiKey_RightArrow, ImGuiKey_LeftArrow, ImGuiKey_DownArrow,
                             ImGuiKey_UpArrow, ImGuiKey_PageUp, ImGuiKey_PageDown}) {
    if (ImGui::IsKeyDown(ImGui::GetKeyIndex(key))) return true;
  }
  return false;
}

/// Moves the selected light with the arrow keys; a held key makes one step of the history.
void nudge_light(UiState& ui, Session& session) {
  ViewState& view = session.view();
  ui.nudging = is_nudge_key_down();
  const vec3 motion = asked_motion();
  if (motion == vec3(0) || view.selected_light < 0 ||
      view.selected_light >= static_cast<int>(view.lights.size())) {
    return;
  }
  Light& light = view.lights[static_cast<size_t>(view.selected_light)];
  const SessionInfo& info = session.info();
  const vec3 from = light_handle(light, info.bounds);
  set_light_handle(light, info.bounds,
                   from + move_as_target(session.rays(), info.camera, from, motion));
}

void help_row(const char* key, const char* does) {
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(accent_color), "%s", key);
  ImGui::SameLine(7.5f * ImGui::GetFontSize());
  ImGui::TextUnformatted(does);
}

void help_heading(std::string_view text) {
  ImGui::Spacing();
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "%s", std::string(text).c_str());
}

void help_column(std::initializer_list<ActionGroup> groups) {
  for (const ActionGroup group : groups) {
    help_heading(label_of(action_group_labels, group));
    for (const Action& action : all_actions()) {
      if (action.group == group) help_row(action.shown_key, action.label);
    }
  }
}

}  // namespace

void handle_keys(UiState& ui, Workspace& workspace) {
  const ImGuiIO& io = ImGui::GetIO();
  ui.nudging = false;
  if (io.WantTextInput) return;
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false)) {
    ui.show_help = false;
    ui.tool = PlaceTool::none;
  }
  if (ui.dialog.purpose != FileDialog::Purpose::none) return;
  for (const Action& action : all_actions()) {
    if (is_pressed(action.key) && is_enabled(action, workspace)) action.act(ui, workspace);
  }
  // The other usual key for it.
  if (is_pressed({.character = 'Y', .ctrl = true}) && workspace.session()) workspace.redo();
  if (workspace.session() == nullptr) return;
  if (!io.KeyCtrl) select_by_digit(workspace.session()->view());
  nudge_light(ui, *workspace.session());
}

void help_window(UiState& ui) {
  if (!ui.show_help) return;
  const float font = ImGui::GetFontSize();
  const vec2 room = from_im(ImGui::GetIO().DisplaySize);
  const bool has_columns = room.x >= least_width_in_fonts * font;
  const vec2 center = has_columns ? ui.layout.picture.center() : 0.5f * room;
  ImGui::SetNextWindowPos(to_im(center), ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({0, 0}, to_im(room));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {1.5f * font, 0.8f * font});
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, 0.22f * font});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.08f, 0.08f, 0.08f, 0.95f));
  // Scrolls where the window is lower than the list.
  ImGui::Begin("keys", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoNav);
  ImGui::BeginGroup();
  help_heading("In the picture");
  for (const Gesture& gesture : gestures) help_row(gesture.keys, gesture.does);
  help_column({ActionGroup::file, ActionGroup::edit, ActionGroup::window});
  ImGui::EndGroup();
  if (has_columns) ImGui::SameLine(0, 2.5f * font);
  ImGui::BeginGroup();
  help_column({ActionGroup::light, ActionGroup::place, ActionGroup::view});
  ImGui::EndGroup();
  ui.items.note("keys", {from_im(ImGui::GetWindowPos()),
                         from_im(ImGui::GetWindowPos()) + from_im(ImGui::GetWindowSize())});
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

}  // namespace relume

#include "viewer/panels/actions.h"

#include <imgui.h>

#include "viewer/panels/compare_panel.h"
#include "viewer/session/light_edits.h"

namespace relume {
namespace {

constexpr float exposure_step = 0.5f;  // stops
constexpr float gain_step = 0.25f;     // stops
constexpr float trade_step = 0.125f;

Light* selected_light(Workspace& workspace) {
  ViewState& view = workspace.session()->view();
  const bool exists =
      view.selected_light >= 0 && view.selected_light < static_cast<int>(view.lights.size());
  return exists ? &view.lights[static_cast<size_t>(view.selected_light)] : nullptr;
}

void show(Workspace& workspace, ShownPicture shown) {
  workspace.session()->view().shown = shown;
}

void add_gain(Workspace& workspace, float stops) {
  Light* light = selected_light(workspace);
  if (light == nullptr) return;
  const Light before = *light;
  light->gain *= std::exp2(stops);
  limit_light(*light, before);
}

void toggle_shadows(Workspace& workspace) {
  Session& session = *workspace.session();
  ShadowMethod& method = session.view().shadows;
  const bool on = method == ShadowMethod::none && session.info().can_trace;
  method = on ? ShadowMethod::ray : ShadowMethod::none;
}

void copy_command(Workspace& workspace) {
  const std::string command = workspace.copy_command();
  if (!command.empty()) ImGui::SetClipboardText(command.c_str());
}

void save(UiState& ui, Workspace& workspace) {
  if (workspace.document().empty()) {
    open_file_dialog(ui, FileDialog::Purpose::save, "");
  } else {
    workspace.save(workspace.document());
  }
}

bool always(const Workspace&) {
  return true;
}
bool has_reference(const Workspace& workspace) {
  return workspace.session() != nullptr && workspace.session()->info().has_reference;
}
bool has_light(const Workspace& workspace) {
  return workspace.session() != nullptr && workspace.session()->view().selected_light >= 0;
}
/// Pixels stay where the middle of the window is.
void show_pixels(const UiState& ui, ViewState& view) {
  view.zoom_center_px = ui.placement.film_from_screen(ui.placement.area.center());
  view.zoom = 1;
}

/// Choosing a tool again leaves it.
void use_tool(UiState& ui, PlaceTool tool) {
  ui.tool = ui.tool == tool ? PlaceTool::none : tool;
}
bool can_place(const Workspace& workspace) {
  return has_light(workspace) && workspace.session()->tracer() != nullptr;
}
bool has_undo(const Workspace& workspace) {
  return workspace.history().can_undo();
}
bool has_redo(const Workspace& workspace) {
  return workspace.history().can_redo();
}

bool can_trade(const Workspace& workspace) {
  return workspace.session() != nullptr && workspace.can_trade();
}
void step_trade(Workspace& workspace, float step) {
  ViewState& view = workspace.session()->view();
  view.trade.kind = TradeKind::level;
  view.trade.level = std::clamp(view.trade.level + step, 0.0f, 1.0f);
  apply_trade(view);
}

using enum ActionGroup;
using Purpose = FileDialog::Purpose;

constexpr KeyChord control(char letter, bool shift = false) {
  return {.character = letter, .ctrl = true, .shift = shift};
}

constexpr std::array actions = {
    Action{file, "open", "Open...", control('O'), "ctrl+o",
           [](UiState& ui, Workspace&) { open_file_dialog(ui, Purpose::open, ""); }, always},
    Action{file, "save", "Save session", control('S'), "ctrl+s",
           [](UiState& ui, Workspace& w) { save(ui, w); }, nullptr},
    Action{file, "save_as", "Save session as...", control('S', true), "ctrl+shift+s",
           [](UiState& ui, Workspace& w) {
             open_file_dialog(ui, Purpose::save, w.document().string());
           },
           nullptr},
    Action{file, "export", "Export frame (EXR, a layer per light)", control('E'), "ctrl+e",
           [](UiState&, Workspace& w) { w.export_next_frame(); }, nullptr},
    Action{file, "export_as", "Export frame as...", control('E', true), "ctrl+shift+e",
           [](UiState& ui, Workspace&) { open_file_dialog(ui, Purpose::export_frame, ""); },
           nullptr},
    Action{file, "copy_command", "Copy the command that renders this", control('C', true),
           "ctrl+shift+c", [](UiState&, Workspace& w) { copy_command(w); }, nullptr},
    Action{file,
           "quit",
           "Quit",
           {.character = 'q'},
           "q",
           [](UiState& ui, Workspace&) { ui.quit = true; },
           always},

    Action{edit, "undo", "Undo", control('Z'), "ctrl+z", [](UiState&, Workspace& w) { w.undo(); },
           has_undo},
    Action{edit, "redo", "Redo", control('Z', true), "ctrl+shift+z",
           [](UiState&, Workspace& w) { w.redo(); }, has_redo},

    Action{light,
           "add",
           "Add a light",
           {.character = 'a'},
           "a",
           [](UiState&, Workspace& w) {
             const SessionInfo& info = w.session()->info();
             add_light(w.session()->view(), info.bounds, info.camera);
           },
           nullptr},
    Action{light, "duplicate", "Duplicate", control('D'), "ctrl+d",
           [](UiState&, Workspace& w) { duplicate_light(w.session()->view()); }, has_light},
    Action{light,
           "delete",
           "Delete",
           {.named = ImGuiKey_Delete},
           "delete",
           [](UiState&, Workspace& w) { delete_light(w.session()->view()); },
           has_light},
    Action{light,
           "mute",
           "Mute",
           {.character = 'm'},
           "m",
           [](UiState&, Workspace& w) {
             if (Light* selected = selected_light(w)) selected->mute = !selected->mute;
           },
           has_light},
    Action{light,
           "solo",
           "Solo",
           {.character = 'o'},
           "o",
           [](UiState&, Workspace& w) {
             toggle_solo(w.session()->view(), w.session()->view().selected_light);
           },
           has_light},
    Action{light,
           "brighter",
           "A quarter stop brighter",
           {.character = '.'},
           ".",
           [](UiState&, Workspace& w) { add_gain(w, gain_step); },
           has_light},
    Action{light,
           "darker",
           "A quarter stop darker",
           {.character = ','},
           ",",
           [](UiState&, Workspace& w) { add_gain(w, -gain_step); },
           has_light},
    Action{light,
           "next",
           "Select the next",
           {.character = ']'},
           "]",
           [](UiState&, Workspace& w) { select_next_light(w.session()->view(), 1); },
           has_light},
    Action{light,
           "previous",
           "Select the previous",
           {.character = '['},
           "[",
           [](UiState&, Workspace& w) { select_next_light(w.session()->view(), -1); },
           has_light},
    Action{light,
           "down",
           "Move down the list",
           {.character = '}'},
           "}",
           [](UiState&, Workspace& w) { reorder_light(w.session()->view(), 1); },
           has_light},
    Action{light,
           "up",
           "Move up the list",
           {.character = '{'},
           "{",
           [](UiState&, Workspace& w) { reorder_light(w.session()->view(), -1); },
           has_light},

    Action{place,
           "highlight",
           "Highlight, where clicked",
           {.character = 'g'},
           "g",
           [](UiState& ui, Workspace&) { use_tool(ui, PlaceTool::highlight); },
           can_place},
    Action{place,
           "diffuse",
           "Diffuse peak, where clicked",
           {.character = 'd'},
           "d",
           [](UiState& ui, Workspace&) { use_tool(ui, PlaceTool::diffuse); },
           can_place},
    Action{place,
           "rim",
           "Rim, where clicked",
           {.character = 'b'},
           "b",
           [](UiState& ui, Workspace&) { use_tool(ui, PlaceTool::rim); },
           can_place},
    Action{place,
           "shadow",
           "Drag a shadow",
           {.character = 'j'},
           "j",
           [](UiState& ui, Workspace&) { use_tool(ui, PlaceTool::shadow); },
           can_place},

    Action{view,
           "frame",
           "Frame",
           {.character = 'f'},
           "f",
           [](UiState&, Workspace& w) { show(w, ShownPicture::frame); },
           nullptr},
    Action{view,
           "reference",
           "Reference: every sample, traced",
           {.character = 'r'},
           "r",
           [](UiState&, Workspace& w) { show(w, ShownPicture::reference); },
           has_reference},
    Action{view,
           "heatmap",
           "Measured error",
           {.character = 'h'},
           "h",
           [](UiState&, Workspace& w) { show(w, ShownPicture::heatmap); },
           has_reference},
    Action{view,
           "predicted",
           "Predicted error",
           {.character = 'e'},
           "e",
           [](UiState&, Workspace& w) { show(w, ShownPicture::predicted); },
           nullptr},
    Action{view,
           "records",
           "Records of each pixel",
           {.character = 'k'},
           "k",
           [](UiState&, Workspace& w) { show(w, ShownPicture::records); },
           nullptr},
    Action{view,
           "difference",
           "Frame minus reference",
           {.character = 'y'},
           "y",
           [](UiState&, Workspace& w) { show(w, ShownPicture::difference); },
           has_reference},
    Action{view,
           "visibility",
           "What the selected light reaches",
           {.character = 'v'},
           "v",
           [](UiState&, Workspace& w) { show(w, ShownPicture::visibility); },
           can_place},
    Action{view,
           "type",
           "Sample types",
           {.character = 't'},
           "t",
           [](UiState&, Workspace& w) { show(w, ShownPicture::type); },
           nullptr},
    Action{view,
           "normal",
           "Normals",
           {.character = 'n'},
           "n",
           [](UiState&, Workspace& w) { show(w, ShownPicture::normal); },
           nullptr},
    Action{view,
           "false_color",
           "False colour",
           {.character = 'l'},
           "l",
           [](UiState&, Workspace& w) {
             w.session()->view().false_color = !w.session()->view().false_color;
           },
           nullptr},
    Action{view,
           "exposure_up",
           "Half a stop brighter",
           {.character = '+'},
           "+",
           [](UiState&, Workspace& w) { w.session()->view().display.exposure += exposure_step; },
           nullptr},
    Action{view,
           "exposure_down",
           "Half a stop darker",
           {.character = '-'},
           "-",
           [](UiState&, Workspace& w) { w.session()->view().display.exposure -= exposure_step; },
           nullptr},
    Action{view,
           "shadows",
           "Shadows on or off",
           {.character = 's'},
           "s",
           [](UiState&, Workspace& w) { toggle_shadows(w); },
           nullptr},
    Action{view,
           "pixels",
           "One screen pixel for each pixel",
           {.character = 'x'},
           "x",
           [](UiState& ui, Workspace& w) { show_pixels(ui, w.session()->view()); },
           nullptr},
    Action{view,
           "fit",
           "Fit into the window",
           {.character = 'z'},
           "z",
           [](UiState&, Workspace& w) { w.session()->view().zoom = 0; },
           nullptr},

    Action{view,
           "quicker",
           "Quicker frames, more error",
           {.character = '<'},
           "<",
           [](UiState&, Workspace& w) { step_trade(w, -trade_step); },
           can_trade},
    Action{view,
           "closer",
           "Closer to exact, slower",
           {.character = '>'},
           ">",
           [](UiState&, Workspace& w) { step_trade(w, trade_step); },
           can_trade},

    Action{window,
           "inspector",
           "Pixel inspector",
           {.character = 'i'},
           "i",
           [](UiState& ui, Workspace&) { ui.show_inspector = !ui.show_inspector; },
           nullptr},
    Action{window,
           "histogram",
           "Histogram",
           {.character = 'I'},
           "shift+i",
           [](UiState& ui, Workspace&) { ui.show_histogram = !ui.show_histogram; },
           nullptr},
    Action{window,
           "snapshot",
           "Take a snapshot",
           {.character = 'c'},
           "c",
           [](UiState& ui, Workspace& w) { ui.snapshots.take(*w.session()); },
           nullptr},
    Action{window,
           "flip",
           "Flip to the snapshot",
           {.named = ImGuiKey_Tab},
           "tab",
           [](UiState& ui, Workspace&) { ui.show_snapshot = !ui.show_snapshot; },
           nullptr},
    Action{window,
           "wipe",
           "Wipe with the snapshot",
           {.character = 'w'},
           "w",
           [](UiState& ui, Workspace&) { ui.is_wiping = !ui.is_wiping; },
           nullptr},
    Action{window,
           "restore",
           "Restore the snapshot's lights",
           {.character = 'W'},
           "shift+w",
           [](UiState& ui, Workspace& w) { restore_snapshot(ui, w.session()->view()); },
           nullptr},
    Action{window,
           "panel",
           "Panel",
           {.character = 'p'},
           "p",
           [](UiState& ui, Workspace&) { ui.show_panel = !ui.show_panel; },
           always},
    Action{window,
           "keys",
           "Keys",
           {.character = '?'},
           "?",
           [](UiState& ui, Workspace&) { ui.show_help = !ui.show_help; },
           always},
};

}  // namespace

std::span<const Action> all_actions() {
  return actions;
}

bool is_enabled(const Action& action, const Workspace& workspace) {
  return action.is_enabled != nullptr ? action.is_enabled(workspace)
                                      : workspace.session() != nullptr;
}

void open_file_dialog(UiState& ui, FileDialog::Purpose purpose, const std::string& path) {
  ui.dialog = FileDialog{};
  ui.dialog.purpose = purpose;
  ui.dialog.is_new = true;
  path.copy(ui.dialog.path.data(), ui.dialog.path.size() - 1);
}

}  // namespace relume

#pragma once

#include <span>
#include <string>

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

enum class ActionGroup { file, edit, light, place, view, window };

inline constexpr std::array action_group_labels = {
    Label<ActionGroup>{ActionGroup::file, "File"},
    Label<ActionGroup>{ActionGroup::edit, "Edit"},
    Label<ActionGroup>{ActionGroup::light, "Light"},
    Label<ActionGroup>{ActionGroup::place, "Place"},
    Label<ActionGroup>{ActionGroup::view, "View"},
    Label<ActionGroup>{ActionGroup::window, "Window"},
};

/// The key of an action: a character as typed, or a letter with Ctrl, or one of ImGui's named keys.
struct KeyChord {
  char character = 0;
  bool ctrl = false;   ///< `character` is then a capital letter
  bool shift = false;  ///< with ctrl or a named key
  int named = -1;      ///< ImGuiKey
};

/// Something that a person can do: menus, keys and the list of keys are made from one table.
struct Action {
  ActionGroup group;
  const char* name;  ///< of the item, "menu.NAME"
  const char* label;
  KeyChord key;
  const char* shown_key;  ///< for the menu and the list
  void (*act)(UiState& ui, Workspace& workspace);
  bool (*is_enabled)(const Workspace& workspace);  ///< null: whenever a session is there
};

std::span<const Action> all_actions();

/// False while the action has nothing to act on.
bool is_enabled(const Action& action, const Workspace& workspace);

/// Opens the box for a path.
void open_file_dialog(UiState& ui, FileDialog::Purpose purpose, const std::string& path);

}  // namespace relume

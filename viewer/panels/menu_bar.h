#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// The menus along the top. Items: "menu.file", ..., and while a menu is open "menu.NAME" for each
/// of its actions and "menu.recent.N".
void menu_bar(UiState& ui, Workspace& workspace);

/// The box for a path to open, save or export to, while it is open. Items: "dialog.path",
/// "dialog.accept", "dialog.cancel", "dialog.entry.NAME".
void file_dialog(UiState& ui, Workspace& workspace);

}  // namespace relume

#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// Acts on the keys pressed since the last frame, unless a text field has them.
void handle_keys(UiState& ui, Workspace& workspace);

/// The list of keys, while ui.show_help.
void help_window(UiState& ui);

}  // namespace relume

#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// While the first input is being opened: how far it is, over the tiles that are there.
void load_view(UiState& ui, const Workspace& workspace);

}  // namespace relume

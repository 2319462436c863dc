#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// What the picture shows and how: inside the current ImGui window.
void view_panel(UiState& ui, Workspace& workspace);

/// Along the bottom: what was relit and how long it took, the measured error, problems.
void status_bar(UiState& ui, const Workspace& workspace);

/// Over the picture: what it shows, and the heatmap's scale.
void picture_legend(const UiState& ui, const Session& session);

}  // namespace relume

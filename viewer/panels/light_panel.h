#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/session.h"

namespace relume {

/// The list of lights and the selected light's parameters, inside the current ImGui window.
void light_panel(UiState& ui, Session& session);

}  // namespace relume

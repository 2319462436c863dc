#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// What the pixel under the pointer is made of, over the picture, while ui.show_inspector. Item:
/// "inspector".
void pixel_inspector(UiState& ui, const Session& session);

/// How often each display value occurs, over the picture, while ui.show_histogram. Item:
/// "histogram".
void picture_histogram(UiState& ui, const Session& session, uint64_t session_number);

}  // namespace relume

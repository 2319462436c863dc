#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

/// Snapshots to compare the live picture with, inside the current ImGui window. Items:
/// "snapshot.take", "snapshot.flip", "snapshot.wipe", "snapshot.restore", "snapshot.1", ...
void compare_panel(UiState& ui, Session& session);

/// The wipe's line over the picture, with its handle: item "wipe".
void wipe_line(UiState& ui);

/// The part of the picture's area that the snapshot takes: all, left of the line, or nothing.
Rect snapshot_area(const UiState& ui);

/// Lights and what undo brings back, as the selected snapshot had them.
void restore_snapshot(const UiState& ui, ViewState& view);

}  // namespace relume

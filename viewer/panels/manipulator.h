#pragma once

#include "viewer/panels/ui_state.h"
#include "viewer/session/session.h"

namespace relume {

/// Handles of the lights over the picture: selecting, dragging in the view plane or along a world
/// axis; zooming with the wheel and panning with the middle button. A light outside the picture or
/// behind the camera has its handle near the edge. Items: "handle.N" for light N (from 1),
/// "axis.x", "axis.y", "axis.z" for the selected light.
void light_manipulator(UiState& ui, Session& session);

}  // namespace relume

#pragma once

#include "viewer/commands/relight_input.h"

namespace relume {

/// True when this build has a window and a display is there.
bool can_open_window();

/// Opens the interactive window on `input`, with every sample beside it as the reference when the
/// scene is there. Returns the exit code. Throws Error(usage) when the program was built without.
int open_window(RelightInput input, const ViewOptions& options, const CommonOptions& common);

}  // namespace relume

#pragma once

#include "viewer/commands/relight_input.h"

namespace relume {

/// Throws Error(usage) where `options` do not go with a range of frames, before anything is
/// prepared.
void check_can_render_frames(const RenderOptions& options);

/// Renders options.frames of the animated lights, a file each. EXR frames that this command made
/// before are kept. A frame that fails is told and the others are still made: the exit code is then
/// that of the first failure. Prints a row a frame.
int render_frames(const RenderOptions& options, const RelightInput& input,
                  const CommonOptions& common);

}  // namespace relume

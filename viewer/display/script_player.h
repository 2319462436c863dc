#pragma once

#include <filesystem>

#include "core/image/image.h"
#include "viewer/display/screen.h"
#include "viewer/display/script.h"
#include "viewer/display/surface.h"

namespace relume {

/// Plays a script: the same input, frame by frame, with a fixed time step and with the session
/// given time to finish after each frame, so that two runs draw the same bytes. `screen` should
/// have been made without timings. Screenshots go to `folder`. Throws Error(input) naming the step
/// when an item does not exist, Error(output) when OpenGL reports an error or a file cannot be
/// written.
void play_script(const Script& script, Workspace& workspace, Screen& screen, const GlTable& gl,
                 Surface& surface, const std::filesystem::path& folder);

/// What stands in the framebuffer now, RGB.
DisplayImage read_framebuffer(const GlTable& gl, ivec2 size_px);

}  // namespace relume

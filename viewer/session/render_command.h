#pragma once

#include <string>

#include "viewer/session/session.h"
#include "viewer/session/session_file.h"

namespace relume {

/// The shell command with which `relume render` makes the picture that the session shows: the frame
/// with its records, or all samples with traced shadows where those are on the screen. `lights` is
/// a file that holds shown_lights(); `output` the picture to write.
std::string render_command(const SessionFile& origin, const Session& session,
                           const std::string& lights, const std::string& output);

/// True when the picture is all samples with traced shadows.
bool shows_all_samples(const Session& session);

}  // namespace relume

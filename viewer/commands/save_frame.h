#pragma once

#include <filesystem>

#include "core/image/display_transform.h"
#include "core/relight/relight.h"
#include "viewer/commands/options.h"

namespace relume {

/// Writes state.frame: a path that ends in .exr gets scene-linear beauty (R, G, B), one layer per
/// light (light.<name>.R ...) that sum to it, coverage (A) and metadata; any other a PNG through
/// `display`.
void save_frame(const RelightState& state, const DisplayTransform& display,
                const std::filesystem::path& path);

}  // namespace relume

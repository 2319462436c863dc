#pragma once

#include <filesystem>

#include "viewer/aovs/aov_reader.h"

namespace relume {

/// Writes a proxy made of the samples alone: OUTPUT.proxy.json, a scene with the samples' camera
/// and three lights, and OUTPUT.proxy.glb, a square for each sample that fills its part of the
/// picture along its surface. What the view does not see is not there. Returns the scene's path.
/// Throws Error(limit) above 16 million samples, Error(output).
std::filesystem::path write_splat_proxy(const AovSamples& samples,
                                        const std::filesystem::path& output);

}  // namespace relume

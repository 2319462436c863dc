#pragma once

#include <filesystem>

#include "core/base/progress.h"
#include "core/samples/sample_scene.h"

namespace relume {

/// Writes every sample of a view as a flat AOV image of `samples_per_side` times its resolution,
/// one sample a sub-pixel: the channels of the preset "relume" (P, bias, N, T, material fields,
/// id), as far as the view's types have them. `view` has samples_per_side^2 samples a pixel. Throws
/// Error(limit) above 16384 sub-pixels a side, before anything is sampled.
void write_aovs(const ViewSampler& view, int samples_per_side, const std::filesystem::path& path,
                const ProgressCallback& progress);

}  // namespace relume

#pragma once

#include <filesystem>

#include "core/image/display_transform.h"
#include "core/relight/relight.h"
#include "viewer/frames/frame_recipe.h"

namespace relume {

/// Writes state.frame: a path that ends in .exr gets make_frame_layers() and make_frame_metadata(),
/// any other a PNG through `display`.
void save_frame(const RelightState& state, const DisplayTransform& display,
                const std::filesystem::path& path, const FrameRecipe& recipe);

/// Writes the predicted error of each pixel in false colour with an automatic scale, as a PNG.
/// Throws Error(usage) when the cache has none.
void save_predicted_error(const RelightCache& cache, const std::filesystem::path& path);

/// Writes how many records each pixel has in false colour, as a PNG (scale: record_map_range).
void save_record_map(const RelightCache& cache, const std::filesystem::path& path);

}  // namespace relume

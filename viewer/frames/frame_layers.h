#pragma once

#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "core/image/image_io.h"
#include "core/relight/relight.h"
#include "viewer/frames/frame_recipe.h"

namespace relume {

/// What commands take for the scene that a cache was made from: its file, or a built-in label.
std::string scene_input(const CacheInfo& info);

/// The layers of a frame's file and the images they show. Points into the RelightState.
struct FrameLayers {
  std::deque<Image> images;
  std::vector<ExrLayer> layers;
};

/// Beauty (R, G, B), coverage (A), one layer a light (light.<name>.R ...) and emission
/// (emission.R ...) where the cache has it, that sum to beauty,
/// records per pixel (records.V), predicted error where the cache has it (predicted_error.V), and
/// the AOVs that `recipe` asks for. Throws Error(usage) for an AOV that the cache cannot give.
FrameLayers make_frame_layers(const RelightState& state, const FrameRecipe& recipe);

/// Attributes by name.
using FrameMetadata = std::vector<std::pair<std::string, std::string>>;

/// All that is needed to make the frame again, as a file's attributes (docs/frame-format.md).
FrameMetadata make_frame_metadata(const RelightCache& cache, const std::vector<Light>& lights,
                                  const FrameRecipe& recipe);

}  // namespace relume

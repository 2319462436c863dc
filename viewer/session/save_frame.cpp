#include "viewer/session/save_frame.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/image/heatmap.h"
#include "core/image/image_io.h"
#include "viewer/frames/frame_layers.h"
#include "viewer/session/view_state.h"

namespace relume {

void save_frame(const RelightState& state, const DisplayTransform& display,
                const std::filesystem::path& path, const FrameRecipe& recipe) {
  if (path.extension() == ".exr") {
    write_exr(path, make_frame_layers(state, recipe).layers,
              make_frame_metadata(*state.cache, state.lights, recipe));
  } else if (path.extension() == ".png") {
    write_png(path, apply_display(state.frame, display));
  } else {
    throw Error(ErrorKind::usage, path.string() + ": unknown picture format; use .exr or .png");
  }
}

void save_predicted_error(const RelightCache& cache, const std::filesystem::path& path) {
  const CacheInfo& info = cache.info();
  if (!info.has_predicted_error) {
    throw Error(ErrorKind::usage,
                fmt::format("--predicted-error: method {} predicted no errors", info.method));
  }
  write_png(path, render_heatmap(make_map(info.width, info.height, cache.predicted_error()), {}));
}

void save_record_map(const RelightCache& cache, const std::filesystem::path& path) {
  const CacheInfo& info = cache.info();
  write_png(path, render_heatmap(make_map(info.width, info.height, cache.record_counts()),
                                 {.range = record_map_range(info.records)}));
}

}  // namespace relume

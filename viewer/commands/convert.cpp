#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/timer.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/aovs/deep_records.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/frames/frame_layers.h"
#include "viewer/frames/light_rig_usd.h"

namespace relume {
namespace {

constexpr uint64_t max_light_file_bytes = uint64_t{64} << 20;

std::vector<Light> load_light_file(const std::filesystem::path& path) {
  return parse_lights(read_text_file(path, max_light_file_bytes), path.string());
}

/// Of a cache, or of a scene whose lights may need its geometry.
std::vector<Light> load_rig(const ConvertOptions& options, const CommonOptions& common) {
  if (options.lights) return load_light_file(*options.lights);
  if (is_cache_path(options.input)) {
    return RelightCache::open(options.input, shader_table()).info().lights;
  }
  return load_scene(options.input, shader_table(), make_terminal_progress(common.quiet)).lights;
}

FigureRow convert_to_rig(const ConvertOptions& options, const CommonOptions& common) {
  const std::vector<Light> lights = load_rig(options, common);
  write_file_atomic(options.output, format_light_rig_usd(lights));
  return {{"lights", static_cast<int64_t>(lights.size())}};
}

FigureRow convert_to_deep(const ConvertOptions& options, const CommonOptions& common) {
  const RelightInput input = open_input(options.input, prepare_for(options.shadow, options.prepare),
                                        options.shadow != ShadowMethod::none, common);
  const auto shadows =
      input.tracer ? make_shadow(options.shadow, *input.tracer, *input.cache) : nullptr;
  const std::vector<Light> lights =
      options.lights ? load_light_file(*options.lights) : input.cache->info().lights;
  const DeepImage image = make_deep_records(*input.cache, lights, shadows.get());
  write_deep_exr(options.output, image,
                 make_frame_metadata(*input.cache, lights,
                                     {.shadow = options.shadow, .scene = input.scene.get()}));
  return {{"scene", input.cache->info().scene_name},
          {"width", int64_t{image.width}},
          {"height", int64_t{image.height}},
          {"channels", static_cast<int64_t>(image.channels.size())},
          {"samples", static_cast<int64_t>(image.values.size() / image.channels.size())}};
}

}  // namespace

int run_convert(const ConvertOptions& options, const CommonOptions& common) {
  const Timer timer;
  const std::string extension = options.output.extension().string();
  FigureRow row;
  if (extension == ".exr") {
    row = convert_to_deep(options, common);
  } else if (extension == ".usda") {
    row = convert_to_rig(options, common);
  } else {
    throw Error(ErrorKind::usage, options.output.string() +
                                      ": unknown format; use .exr for deep records, .usda for "
                                      "lights");
  }
  row.push_back({"output", options.output.string()});
  row.push_back({"ms", timer.ms()});
  print_figures("relume-convert-1", common, {row});
  return 0;
}

}  // namespace relume

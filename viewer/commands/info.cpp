#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"

namespace relume {
namespace {

/// Budgets of 0 are none; footprints and members: 1 where the cache has them; means are over
/// covered pixels.
FigureRow describe_cache(const std::filesystem::path& path) {
  const RelightCache cache = RelightCache::open(path, shader_table());
  const CacheInfo& info = cache.info();
  std::string types;
  for (const SampleType& type : info.types) types += (types.empty() ? "" : ", ") + type.name;
  const std::vector<float> coverage = cache.coverage();
  FigureRow row = {{"kind", "cache"},
                   {"scene", info.scene_name},
                   {"scene_file", info.scene_file},
                   {"width", int64_t{info.width}},
                   {"height", int64_t{info.height}},
                   {"method", info.method},
                   {"records", int64_t{info.records}},
                   {"budget_records", double{info.average_records}},
                   {"budget_error", double{info.target_error}},
                   {"spp", int64_t{info.spp}},
                   {"seed", static_cast<int64_t>(info.seed)},
                   {"types", types},
                   {"lights", static_cast<int64_t>(info.lights.size())},
                   {"sample_count", static_cast<int64_t>(info.sample_count)},
                   {"record_count", static_cast<int64_t>(info.record_count)},
                   {"records_per_pixel", mean_covered(cache.record_counts(), coverage)},
                   {"footprints", int64_t{info.has_footprints}},
                   {"members", int64_t{info.has_members}},
                   {"emission", int64_t{info.has_emission}},
                   {"bytes", static_cast<int64_t>(cache.size_bytes())}};
  if (info.has_predicted_error) {
    row.push_back({"predicted_error", mean_covered(cache.predicted_error(), coverage)});
  }
  return row;
}

FigureRow describe_image(const std::filesystem::path& path) {
  const Image image = read_image(path);
  std::string channels;
  for (const std::string& name : read_channel_names(path)) {
    channels += (channels.empty() ? "" : ", ") + name;
  }
  return {{"kind", "image"},
          {"width", int64_t{image.width}},
          {"height", int64_t{image.height}},
          {"channels", channels}};
}

FigureRow describe_scene(const std::string& name) {
  const Scene scene = load_scene(name, shader_table());
  const SceneCounts counts = count_scene(scene);
  const Bounds bounds = world_bounds(scene);
  return {{"kind", "scene"},
          {"scene", scene.name},
          {"width", int64_t{scene.width}},
          {"height", int64_t{scene.height}},
          {"triangles", static_cast<int64_t>(counts.triangles)},
          {"instanced_triangles", static_cast<int64_t>(counts.instanced_triangles)},
          {"strands", static_cast<int64_t>(counts.strands)},
          {"instanced_segments", static_cast<int64_t>(counts.instanced_segments)},
          {"instances", static_cast<int64_t>(scene.instances.size())},
          {"materials", static_cast<int64_t>(scene.materials.size())},
          {"textures", static_cast<int64_t>(scene.textures.size())},
          {"lights", static_cast<int64_t>(scene.lights.size())},
          {"radius", double{bounds.radius()}}};
}

}  // namespace

int run_info(const InfoOptions& options, const CommonOptions& common) {
  const std::string extension = std::filesystem::path(options.input).extension().string();
  FigureRow row;
  if (extension == ".relume") {
    row = describe_cache(options.input);
  } else if (extension == ".exr" || extension == ".png" || extension == ".jpg") {
    row = describe_image(options.input);
  } else {
    row = describe_scene(options.input);
  }
  print_figures("relume-info-1", common, {row});
  return 0;
}

}  // namespace relume

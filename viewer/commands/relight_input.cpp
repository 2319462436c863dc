#include "viewer/commands/relight_input.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

void report_tracer(const Scene& scene, const Tracer& tracer, const CommonOptions& common) {
  if (!common.verbose) return;
  const SceneCounts counts = count_scene(scene);
  const TracerStats& stats = tracer.stats();
  fmt::print(stderr,
             "{}: {} triangles ({} instanced), {} strands, {} segments ({} instanced); built in "
             "{:.0f} ms, {:.0f} MiB, {}\n",
             scene.name, counts.triangles, counts.instanced_triangles, counts.strands,
             counts.segments, counts.instanced_segments, stats.build_ms,
             static_cast<double>(stats.memory_bytes) / (1 << 20),
             stats.flattened ? "flattened" : "instanced");
}

RelightInput trace_scene(Scene scene, const CommonOptions& common) {
  RelightInput input;
  input.scene = std::make_unique<const Scene>(std::move(scene));
  input.tracer = std::make_unique<const Tracer>(*input.scene);
  report_tracer(*input.scene, *input.tracer, common);
  if (has_emission(*input.scene)) {
    fmt::print(stderr,
               "{}: some of its materials emit light: it is seen, but lights nothing else\n",
               input.scene->name);
  }
  return input;
}

ProgressCallback progress_of(const OpenHooks& hooks, const CommonOptions& common) {
  return hooks.progress ? hooks.progress : make_terminal_progress(common.quiet);
}

/// The scene that a cache was made from.
Scene scene_of_cache(const CacheInfo& info, const std::string& place) {
  try {
    return parse_scene(info.scene_text, info.scene_file, shader_table());
  } catch (const Error& error) {
    throw input_error(
        place, fmt::format("traced shadows need the scene it was made from ({})", error.what()),
        "put the files back or use --shadow none");
  }
}

}  // namespace

bool is_cache_path(const std::string& path) {
  return std::filesystem::path(path).extension() == ".relume";
}

PrepareOptions prepare_for(ShadowMethod shadow, PrepareOptions options) {
  const bool uses_members = shadow == ShadowMethod::members || shadow == ShadowMethod::coverage ||
                            shadow == ShadowMethod::automatic;
  if (uses_members && !options.members) options.members = max_members;
  return options;
}

PrepareOptions all_samples(PrepareOptions options) {
  options.method = ReductionMethod::all;
  options.budget = {};
  options.frame_ms = 0;
  options.predict_error = false;
  options.preset = ReductionPreset::standard;
  return options;
}

PrepareParams make_prepare_params(const PrepareOptions& options, const CommonOptions& common) {
  PrepareParams params;
  params.spp = options.spp;
  params.format = options.format;
  params.frame_ms = options.frame_ms;
  params.frame_shadows = options.frame_shadows;
  params.width = options.width;
  params.height = options.height;
  params.training = {.lights = options.training_lights, .shadows = options.train_shadows};
  if (options.preset == ReductionPreset::report_faithful) {
    if (!is_report_method(options.method)) {
      throw Error(ErrorKind::usage,
                  fmt::format("--preset {}: {} is not one of the report's methods",
                              label_of(reduction_preset_labels, options.preset),
                              label_of(reduction_method_labels, options.method)));
    }
    params.reduction = report_faithful_params(options.method);
    params.training.shadows = report_faithful_training().shadows;
  } else {
    params.reduction.method = options.method;
  }
  if (options.budget.average_records > 0 && options.budget.target_error > 0) {
    throw Error(ErrorKind::usage,
                "--average-records and --target-error exclude each other; give one of them");
  }
  if (options.frame_ms > 0 && (options.budget.is_set() || options.records)) {
    throw Error(ErrorKind::usage,
                "--frame-ms chooses the records: give no --records, --average-records or "
                "--target-error beside it");
  }
  const bool has_goal = options.frame_ms > 0 || options.budget.is_set();
  const bool is_reduced =
      options.method != ReductionMethod::all && options.method != ReductionMethod::pure;
  if (!is_reduced && (has_goal || options.predict_error)) {
    throw Error(ErrorKind::usage,
                fmt::format("--method {} does not reduce: it has no budget and predicts no error",
                            label_of(reduction_method_labels, options.method)));
  }
  params.budget = options.budget;
  params.reduction.predict_error = options.predict_error;
  params.reduction.stored_members = options.members.value_or(0);
  params.reduction.records = options.records.value_or(has_goal ? 16 : 8);
  params.reduction.seed = common.seed;
  params.training.seed = common.seed;
  return params;
}

RelightInput open_scene(const std::string& name_or_path, const CommonOptions& common,
                        const OpenHooks& hooks) {
  return trace_scene(load_scene(name_or_path, shader_table(), progress_of(hooks, common)), common);
}

RelightInput open_study_scene(const std::string& name_or_path, const CommonOptions& common) {
  Scene scene = load_scene(name_or_path, shader_table(), make_terminal_progress(common.quiet));
  if (has_emission(scene)) {
    fmt::print(stderr, "{}: what its materials emit is left out: studies are of lights\n",
               scene.name);
    remove_emission(scene);
  }
  return trace_scene(std::move(scene), common);
}

RelightInput open_input(const std::string& input, const PrepareOptions& prepare, bool need_tracer,
                        const CommonOptions& common, const OpenHooks& hooks) {
  if (is_cache_path(input)) {
    RelightCache cache = RelightCache::open(input, shader_table());
    RelightInput result;
    if (need_tracer) result = trace_scene(scene_of_cache(cache.info(), input), common);
    result.cache = std::move(cache);
    return result;
  }
  PrepareParams params = make_prepare_params(prepare, common);
  params.on_tile = hooks.on_tile;
  RelightInput result = open_scene(input, common, hooks);
  result.cache =
      prepare_in_memory(*result.scene, *result.tracer, params, progress_of(hooks, common));
  return result;
}

}  // namespace relume

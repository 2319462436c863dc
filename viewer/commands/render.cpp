#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/timer.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/commands/render_frames.h"
#include "viewer/session/save_frame.h"

namespace relume {
namespace {

constexpr uint64_t max_light_file_bytes = uint64_t{64} << 20;

std::vector<Light> choose_lights(const RenderOptions& options, const CacheInfo& info) {
  if (!options.lights) return info.lights;
  return parse_lights(read_text_file(*options.lights, max_light_file_bytes),
                      options.lights->string());
}

/// --reference is a way to say: every sample a record, and a traced shadow ray for each.
RenderOptions resolve_reference(RenderOptions options) {
  if (!options.reference) return options;
  if (is_cache_path(options.input)) {
    throw Error(ErrorKind::usage,
                options.input + ": a cache holds no samples for --reference; give the scene");
  }
  options.prepare.method = ReductionMethod::all;
  options.shadow = ShadowMethod::ray;
  return options;
}

/// A scene whose predicted error is to be written is prepared with it, where its method reduces.
RenderOptions resolve_predicted_error(RenderOptions options) {
  const ReductionMethod method = options.prepare.method;
  const bool is_reduced = method != ReductionMethod::all && method != ReductionMethod::pure;
  const auto wanted = std::find(options.aovs.begin(), options.aovs.end(), FrameAov::error);
  if (is_reduced && wanted != options.aovs.end()) options.prepare.predict_error = true;
  return options;
}

}  // namespace

int run_render(const RenderOptions& asked, const CommonOptions& common) {
  const RenderOptions options = resolve_predicted_error(resolve_reference(asked));
  if (options.frames) check_can_render_frames(options);
  const Timer timer;
  const RelightInput input = open_input(options.input, prepare_for(options.shadow, options.prepare),
                                        options.shadow != ShadowMethod::none, common);
  const CacheInfo& info = input.cache->info();
  const double prepare_ms = timer.ms();
  if (options.predicted_error) save_predicted_error(*input.cache, *options.predicted_error);
  if (options.record_map) save_record_map(*input.cache, *options.record_map);
  if (options.frames) return render_frames(options, input, common);

  const auto shadows =
      input.tracer ? make_shadow(options.shadow, *input.tracer, *input.cache) : nullptr;
  RelightState state = make_relight_state(*input.cache);
  const RelightStats stats = relight(state, choose_lights(options, info), shadows.get(),
                                     {.instruction_set = options.instruction_set});

  save_frame(state, display_of(options, info), options.output,
             {.shadow = options.shadow,
              .shadows = shadows.get(),
              .scene = input.scene.get(),
              .instruction_set = options.instruction_set,
              .aovs = options.aovs});
  print_figures(
      "relume-render-1", common,
      {{{"scene", info.scene_name},
        {"method", info.method},
        {"records", int64_t{info.records}},
        {"spp", int64_t{info.spp}},
        {"shadow", std::string(label_of(shadow_method_labels, options.shadow))},
        {"lights", static_cast<int64_t>(state.lights.size())},
        {"output", options.output.string()},
        {"ms_prepare", prepare_ms},
        {"ms_light", (stats.prepare_ms + stats.shade_ms) / std::max(1, stats.layers_shaded)},
        {"ms_combine", stats.combine_ms},
        {"record_count", static_cast<int64_t>(info.record_count)},
        {"replaced_values", static_cast<int64_t>(stats.replaced_values)}}});
  return 0;
}

}  // namespace relume

#include "core/base/error.h"
#include "core/shade/shaders.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/relight_input.h"
#if defined(RELUME_HAS_VIEWER)
#include "viewer/display/run_viewer.h"
#include "viewer/session/recent_files.h"
#endif

namespace relume {
namespace {

#if defined(RELUME_HAS_VIEWER)
/// Any budget: a forecast is for all of them.
constexpr RecordChoice any_records{.average = 8};

/// Prepares every sample of the session's scene for the reference.
auto make_reference_maker(const Session& session, const SessionFile& file,
                          const CommonOptions& common) {
  PrepareOptions all = all_samples(file.prepare);
  all.width = session.info().width;
  all.height = session.info().height;
  const PrepareParams params = make_prepare_params(all, common);
  return [&session, params](const ProgressCallback& progress) {
    const Tracer& tracer = *session.tracer();
    return make_cache_source(prepare_in_memory(tracer.scene(), tracer, params, progress), &tracer,
                             ShadowMethod::ray);
  };
}

/// Prepares the session's scene again; nothing where the input's samples were not reduced. What
/// comes of a session that is closed meanwhile is thrown away before its scene is.
RecordSource make_record_source(const Session& session, const SessionFile& file,
                                CommonOptions common) {
  const bool is_cache = is_cache_path(file.input);
  const CacheInfo& info = session.cache()->info();
  const auto options = is_cache ? options_of(info) : std::optional(file.prepare);
  const bool is_reduced = options_of(info).has_value();
  if (!is_reduced || session.tracer() == nullptr) return {};
  if (is_cache) common.seed = info.seed;
  const PrepareOptions base = chosen_options(*options, info);
  const Tracer& tracer = *session.tracer();
  RecordSource source;
  source.forecast = [&tracer,
                     params = make_prepare_params(with_records(base, any_records), common)](
                        const ProgressCallback& progress) {
    return forecast_scene(tracer.scene(), tracer, params, progress);
  };
  source.prepare = [&tracer, base, common, is_cache, input = file.input](
                       const RecordChoice& choice, float record_cost,
                       const ProgressCallback& progress) {
    if (is_cache && !choice.is_set()) {
      return make_session_records(RelightCache::open(input, shader_table()), &tracer);
    }
    PrepareParams params = make_prepare_params(with_records(base, choice), common);
    params.record_cost = choice.is_set() ? record_cost : 0;
    return make_session_records(prepare_in_memory(tracer.scene(), tracer, params, progress),
                                &tracer);
  };
  return source;
}

/// What `automatic` picks depends on the machine's speed: scripts write the same pictures anywhere.
ShadowMethod shadow_of(const ViewOptions& options) {
  return options.shadow.value_or(options.offscreen ? ShadowMethod::ray : ShadowMethod::automatic);
}

void apply_options(const ViewOptions& options, ViewState& view) {
  if (options.shadow || view.shadows != ShadowMethod::none) view.shadows = shadow_of(options);
  view.frame_ms = options.frame_ms.value_or(view.frame_ms);
  view.display.curve = default_curve();
  view.refine = !options.keep_records && !options.offscreen;
}

OpenedInput start_session(RelightInput input, const SessionFile& file, const ViewOptions& options,
                          const CommonOptions& common) {
  OpenedInput opened;
  // No copy is made: a session cannot move.
  opened.session.reset(new Session(make_session(std::move(input.scene), std::move(input.tracer),
                                                std::move(*input.cache), std::nullopt)));
  apply_options(options, opened.session->view());
  if (opened.session->tracer() != nullptr) {
    opened.make_reference = make_reference_maker(*opened.session, file, common);
    opened.records = make_record_source(*opened.session, file, common);
  }
  return opened;
}

InputOpener make_opener(const ViewOptions& options, const CommonOptions& asked) {
  return [options, asked](const SessionFile& file, const ProgressCallback& progress,
                          PreparePreview& preview) {
    CommonOptions common = asked;
    common.seed = file.seed;
    const OpenHooks hooks{progress, [&preview](const ViewSampler& view, const SampleTile& records) {
                            preview.add_tile(view, records);
                          }};
    const PrepareOptions prepare = with_records(file.prepare, file.view.records);
    return start_session(open_input(file.input, prepare, true, common, hooks), file, options,
                         common);
  };
}

WorkspaceOptions workspace_options(const ViewOptions& options, const CommonOptions& common) {
  PrepareOptions prepare = prepare_for(shadow_of(options), options.prepare);
  // Shadows have levels of their own to keep to the time.
  if (!prepare.records && !prepare.budget.is_set()) prepare.frame_ms = options.frame_ms.value_or(0);
  return {.state_folder = options.offscreen ? std::filesystem::path() : default_state_folder(),
          .work_folder = options.offscreen.value_or("."),
          .prepare = prepare,
          .seed = common.seed};
}
#else
Error no_viewer() {
  return Error(ErrorKind::usage,
               "this program was built without the window; configure with -DRELUME_VIEWER=ON");
}
#endif

}  // namespace

bool can_open_window() {
#if defined(RELUME_HAS_VIEWER)
  return display_available();
#else
  return false;
#endif
}

int run_view([[maybe_unused]] const ViewOptions& options,
             [[maybe_unused]] const CommonOptions& common) {
#if defined(RELUME_HAS_VIEWER)
  // A mistake in the options is found before anything is loaded.
  make_prepare_params(options.prepare, common);
  const std::optional<Script> script =
      options.script ? std::optional(load_script(*options.script)) : std::nullopt;
  Workspace workspace(make_opener(options, common), options.input,
                      workspace_options(options, common));
  if (options.offscreen) {
    const float scale = options.scale > 0 ? options.scale : 1;
    return run_offscreen(workspace, script.value_or(default_script()), *options.offscreen,
                         {.size_px = ivec2(scale * vec2(1280, 800)), .ui_scale = scale});
  }
  WindowOptions window;
  window.ui_scale = options.scale;
  return run_window(workspace, window);
#else
  throw no_viewer();
#endif
}

}  // namespace relume

#include "core/base/error.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/open_window.h"
#if defined(RELUME_HAS_VIEWER)
#include "viewer/display/run_viewer.h"
#endif

namespace relume {
namespace {

#if defined(RELUME_HAS_VIEWER)
Session start_session(RelightInput input, const PrepareOptions& prepare,
                      const CommonOptions& common) {
  std::optional<RelightCache> reference;
  if (input.tracer) {
    PrepareOptions all = all_samples(prepare);
    all.width = input.cache->info().width;
    all.height = input.cache->info().height;
    reference = prepare_in_memory(*input.scene, *input.tracer, make_prepare_params(all, common),
                                  make_terminal_progress(common.quiet));
  }
  return make_session(std::move(input.scene), std::move(input.tracer), std::move(*input.cache),
                      std::move(reference));
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

int open_window([[maybe_unused]] RelightInput input, [[maybe_unused]] const ViewOptions& options,
                [[maybe_unused]] const CommonOptions& common) {
#if defined(RELUME_HAS_VIEWER)
  Session session = start_session(std::move(input), options.prepare, common);
  session.view().shadows = options.shadow;
  session.view().frame_ms = options.frame_ms.value_or(session.view().frame_ms);
  session.view().refine = !options.keep_records;
  return run_window(session, {});
#else
  throw no_viewer();
#endif
}

int run_view(const ViewOptions& options, const CommonOptions& common) {
  PrepareOptions prepare = prepare_for(options.shadow, options.prepare);
  // Shadows have levels of their own to keep to the time.
  if (!prepare.records && !prepare.budget.is_set()) prepare.frame_ms = options.frame_ms.value_or(0);
  RelightInput input = open_input(options.input, prepare, true, common);
#if defined(RELUME_HAS_VIEWER)
  if (options.offscreen) {
    const Script script = options.script ? load_script(*options.script) : default_script();
    Session session = start_session(std::move(input), options.prepare, common);
    session.view().shadows = options.shadow;
    session.view().frame_ms = options.frame_ms.value_or(session.view().frame_ms);
    return run_offscreen(session, script, *options.offscreen);
  }
  return open_window(std::move(input), options, common);
#else
  throw no_viewer();
#endif
}

}  // namespace relume

#include "core/base/timer.h"
#include "viewer/aovs/aov_writer.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"

namespace relume {

int run_sample(const SampleOptions& options, const CommonOptions& common) {
  const Timer timer;
  const RelightInput input = open_scene(options.scene, common);
  const ViewSampler view = make_view_sampler(
      *input.scene, *input.tracer, options.width > 0 ? options.width : input.scene->width,
      options.height > 0 ? options.height : input.scene->height,
      options.samples_per_side * options.samples_per_side, common.seed);
  write_aovs(view, options.samples_per_side, options.output, make_terminal_progress(common.quiet));
  print_figures("relume-sample-1", common,
                {{{"scene", input.scene->name},
                  {"width", int64_t{view.width}},
                  {"height", int64_t{view.height}},
                  {"spp", int64_t{view.strata.spp}},
                  {"output", options.output.string()},
                  {"ms", timer.ms()}}});
  return 0;
}

}  // namespace relume

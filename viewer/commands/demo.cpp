#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/timer.h"
#include "core/image/heatmap.h"
#include "core/image/image_io.h"
#include "core/image/metrics.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/session/save_frame.h"

namespace relume {
namespace {

/// The first light, carried a third of the way round the scene's centre about the vertical.
std::vector<Light> move_first_light(std::vector<Light> lights, const Bounds& bounds) {
  if (lights.empty()) return lights;
  const float angle = radians_from_degrees(120);
  const auto turn = [angle](vec3 v) {
    return vec3(std::cos(angle) * v.x + std::sin(angle) * v.z, v.y,
                -std::sin(angle) * v.x + std::cos(angle) * v.z);
  };
  Light& light = lights.front();
  light.position = bounds.center() + turn(light.position - bounds.center());
  light.direction = turn(light.direction);
  return lights;
}

/// Everything that the window would show, as files.
int write_pictures(const RelightInput& input, const std::filesystem::path& folder,
                   const DemoOptions& options, const Timer& timer, const CommonOptions& common) {
  make_folder(folder);
  const CacheInfo& info = input.cache->info();
  const DisplayTransform display{.exposure = info.exposure, .curve = default_curve()};
  const auto shadows = make_shadow(ShadowMethod::ray, *input.tracer, *input.cache);
  const FrameRecipe recipe{
      .shadow = ShadowMethod::ray, .shadows = shadows.get(), .scene = &input.tracer->scene()};
  RelightState state = make_relight_state(*input.cache);
  relight(state, info.lights, shadows.get());
  const double first_picture_ms = timer.ms();
  save_frame(state, display, folder / "frame.exr", recipe);
  save_frame(state, display, folder / "frame.png", recipe);
  save_frame(state, display, folder / "before.png", recipe);

  const RelightCache samples = prepare_in_memory(
      *input.scene, *input.tracer, make_prepare_params(all_samples(options.prepare), common),
      make_terminal_progress(common.quiet));
  RelightState reference = make_relight_state(samples);
  const auto traced = make_shadow(ShadowMethod::ray, *input.tracer, samples);
  const RelightStats reference_stats = relight(reference, info.lights, traced.get());
  save_frame(reference, display, folder / "reference.png", {});
  const ImageError error = compare_images(state.frame, reference.frame, samples.coverage());
  write_png(folder / "heatmap.png",
            render_heatmap(error_image(state.frame, reference.frame), {.range = 0.1f}));

  const RelightStats moved =
      relight(state, move_first_light(info.lights, info.bounds), shadows.get());
  save_frame(state, display, folder / "after.png", recipe);

  const double lights = std::max<double>(1, static_cast<double>(info.lights.size()));
  print_figures("relume-demo-1", common,
                {{{"scene", info.scene_name},
                  {"method", info.method},
                  {"records", int64_t{info.records}},
                  {"spp", int64_t{info.spp}},
                  {"s_first_picture", first_picture_ms * 1e-3},
                  {"ms_light", moved.prepare_ms + moved.shade_ms},
                  {"ms_light_reference", reference_stats.shade_ms / lights},
                  {"error_image", error.error_image},
                  {"error", error.error_covered},
                  {"reference_mean", error.reference_mean},
                  {"folder", std::filesystem::absolute(folder).string()}}});
  for (const char* name :
       {"frame.png", "frame.exr", "reference.png", "heatmap.png", "before.png", "after.png"}) {
    fmt::print(stderr, "wrote {}\n", (folder / name).string());
  }
  return 0;
}

}  // namespace

int run_demo(const DemoOptions& options, const CommonOptions& common) {
  const Timer timer;
  if (!options.offscreen && can_open_window()) {
    ViewOptions view;
    view.input = options.scene;
    view.prepare = options.prepare;
    return run_view(view, common);
  }
  const RelightInput input = open_input(options.scene, options.prepare, true, common);
  return write_pictures(input, options.offscreen.value_or("relume-demo"), options, timer, common);
}

}  // namespace relume

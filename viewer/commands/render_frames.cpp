#include "viewer/commands/render_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/base/timer.h"
#include "core/scene/io/load_light_animations.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/json_output.h"
#include "viewer/frames/finished_frame.h"
#include "viewer/session/save_frame.h"

namespace relume {
namespace {

constexpr uint64_t max_light_file_bytes = uint64_t{64} << 20;

/// Lights and what moves them, in the same order.
struct AnimatedLights {
  std::vector<Light> lights;
  std::vector<LightAnimation> animations;
};

/// Those of --lights, else the scene's, whose own values the cache knows.
AnimatedLights load_animated_lights(const RenderOptions& options, const CacheInfo& info) {
  AnimatedLights animated;
  if (options.lights) {
    const std::string text = read_text_file(*options.lights, max_light_file_bytes);
    animated.lights = parse_lights(text, options.lights->string());
    animated.animations = parse_light_animations(text, options.lights->string());
  } else {
    animated.lights = info.lights;
    animated.animations = parse_light_animations(info.scene_text, options.input);
  }
  // Lights that do not stand in the text, as those of an image, do not move.
  animated.animations.resize(animated.lights.size());
  return animated;
}

enum class FrameFate { rendered, kept, failed };

/// Frames of one picture, one after the other.
class FrameMaker {
 public:
  FrameMaker(const RenderOptions& options, const RelightInput& input)
      : options_(options),
        cache_(*input.cache),
        shadows_(input.tracer ? make_shadow(options.shadow, *input.tracer, cache_) : nullptr),
        recipe_{.shadow = options.shadow,
                .shadows = shadows_.get(),
                .scene = input.scene.get(),
                .instruction_set = options.instruction_set,
                .aovs = options.aovs},
        state_(make_relight_state(cache_)) {}

  FrameFate make(const std::vector<Light>& lights, const std::filesystem::path& path) {
    const CacheInfo& info = cache_.info();
    if (is_finished_frame(path, info.width, info.height,
                          make_frame_metadata(cache_, lights, recipe_))) {
      return FrameFate::kept;
    }
    relight(state_, lights, shadows_.get(), {.instruction_set = options_.instruction_set});
    save_picture(state_, options_.exposure.value_or(info.exposure), options_.curve, path, recipe_);
    return FrameFate::rendered;
  }

 private:
  const RenderOptions& options_;
  const RelightCache& cache_;
  std::unique_ptr<VisibilitySource> shadows_;
  FrameRecipe recipe_;
  RelightState state_;
};

/// What came of the frames.
class FrameLog {
 public:
  void add(int frame, const std::filesystem::path& path, FrameFate fate, double ms) {
    constexpr std::array names = {"rendered", "kept", "failed"};
    rows_.push_back({{"frame", int64_t{frame}},
                     {"output", path.string()},
                     {"fate", names[static_cast<size_t>(fate)]},
                     {"ms", ms}});
  }

  void add_failure(int frame, const Error& error) {
    fmt::print(stderr, "relume: frame {}: {}\n", frame, error.what());
    if (failed_.empty()) exit_code_ = error.exit_code();
    failed_.push_back(frame);
  }

  int finish(const CommonOptions& common) const {
    print_figures("relume-render-frames-1", common, rows_);
    if (!failed_.empty()) {
      fmt::print(stderr, "relume: {} of {} frames failed: {}\n", failed_.size(), rows_.size(),
                 fmt::join(failed_, ", "));
    }
    return exit_code_;
  }

 private:
  std::vector<FigureRow> rows_;
  std::vector<int> failed_;
  int exit_code_ = 0;
};

}  // namespace

void check_can_render_frames(const RenderOptions& options) {
  frame_path(options.output, options.frames->first);
  if (options.shadow == ShadowMethod::automatic) {
    throw Error(ErrorKind::usage,
                "--frames: --shadow auto chooses by measured times, which would flicker; name a "
                "shadow method");
  }
}

int render_frames(const RenderOptions& options, const RelightInput& input,
                  const CommonOptions& common) {
  const AnimatedLights animated = load_animated_lights(options, input.cache->info());
  FrameMaker maker(options, input);
  FrameLog log;
  Progress progress(make_terminal_progress(common.quiet), "frames");
  const FrameRange range = *options.frames;
  for (int frame = range.first; frame <= range.last; ++frame) {
    if (interrupted()) {
      throw Error(
          ErrorKind::cancelled,
          fmt::format("interrupted before frame {}; the same command goes on there", frame));
    }
    const Timer timer;
    const std::filesystem::path path = frame_path(options.output, frame);
    FrameFate fate = FrameFate::failed;
    try {
      fate = maker.make(lights_at(animated.lights, animated.animations, static_cast<float>(frame)),
                        path);
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::cancelled) throw;
      log.add_failure(frame, error);
    }
    log.add(frame, path, fate, timer.ms());
    if (!interrupted()) progress.update(frame - range.first + 1, range.count());
  }
  return log.finish(common);
}

}  // namespace relume

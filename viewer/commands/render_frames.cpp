#include "viewer/commands/render_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cstring>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/label.h"
#include "core/base/timer.h"
#include "core/scene/io/load_light_animations.h"
#include "core/scene/io/load_scene.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/work_settings.h"
#include "viewer/farm/shared_work.h"
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
constexpr std::array frame_fate_labels = {
    Label<FrameFate>{FrameFate::rendered, "rendered"},
    Label<FrameFate>{FrameFate::kept, "kept"},
    Label<FrameFate>{FrameFate::failed, "failed"},
};

/// What came of a frame.
struct FrameOutcome {
  FrameFate fate = FrameFate::failed;
  int exit_code = 0;  ///< of a failure
  double ms = 0;
};
static_assert(std::is_trivially_copyable_v<FrameOutcome>);

/// Makes frames of one picture, one after the other.
class FrameMaker {
 public:
  FrameMaker(const RenderOptions& options, const RelightInput& input)
      : options_(options),
        cache_(*input.cache),
        animated_(load_animated_lights(options, cache_.info())),
        shadows_(input.tracer ? make_shadow(options.shadow, *input.tracer, cache_) : nullptr),
        recipe_{.shadow = options.shadow,
                .shadows = shadows_.get(),
                .scene = input.scene.get(),
                .instruction_set = options.instruction_set,
                .aovs = options.aovs},
        state_(make_relight_state(cache_)) {}

  /// A failure is told and does not keep others from being made. Throws Error(cancelled).
  FrameOutcome make(int frame) {
    if (interrupted()) {
      throw Error(
          ErrorKind::cancelled,
          fmt::format("interrupted before frame {}; the same command goes on there", frame));
    }
    const Timer timer;
    FrameOutcome outcome;
    try {
      outcome.fate =
          render(lights_at(animated_.lights, animated_.animations, static_cast<float>(frame)),
                 frame_path(options_.output, frame));
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::cancelled) throw;
      fmt::print(stderr, "relume: frame {}: {}\n", frame, error.what());
      outcome.exit_code = error.exit_code();
    }
    outcome.ms = timer.ms();
    return outcome;
  }

 private:
  FrameFate render(const std::vector<Light>& lights, const std::filesystem::path& path) {
    const CacheInfo& info = cache_.info();
    if (is_finished_frame(path, info.width, info.height,
                          make_frame_metadata(cache_, lights, recipe_))) {
      return FrameFate::kept;
    }
    relight(state_, lights, shadows_.get(), {.instruction_set = options_.instruction_set});
    save_frame(state_, display_of(options_, info), path, recipe_);
    return FrameFate::rendered;
  }

  const RenderOptions& options_;
  const RelightCache& cache_;
  AnimatedLights animated_;
  std::unique_ptr<VisibilitySource> shadows_;
  FrameRecipe recipe_;
  RelightState state_;
};

/// All frames, in their order.
std::vector<FrameOutcome> make_frames(FrameMaker& maker, FrameRange range,
                                      const CommonOptions& common) {
  Progress progress(make_terminal_progress(common.quiet), "frames");
  std::vector<FrameOutcome> outcomes;
  for (int frame = range.first; frame <= range.last; ++frame) {
    outcomes.push_back(maker.make(frame));
    if (!interrupted()) progress.update(frame - range.first + 1, range.count());
  }
  return outcomes;
}

/// The same, with the other processes of the launcher.
std::vector<FrameOutcome> make_frames_together(FrameMaker& maker, FrameRange range,
                                               SharedWork& work, const CommonOptions& common) {
  const auto make = [&](size_t i) {
    const FrameOutcome outcome = maker.make(range.first + static_cast<int>(i));
    const auto bytes = std::as_bytes(std::span(&outcome, 1));
    return SharedWork::Bytes(bytes.begin(), bytes.end());
  };
  std::vector<FrameOutcome> outcomes(static_cast<size_t>(range.count()));
  const int stage =
      work.complete("frames", outcomes.size(), make, make_terminal_progress(common.quiet));
  for (size_t i = 0; i < outcomes.size(); ++i) {
    const SharedWork::Bytes bytes = work.result(stage, i);
    CHECK_MSG(bytes.size() == sizeof(FrameOutcome), "{}", bytes.size());
    std::memcpy(&outcomes[i], bytes.data(), bytes.size());
  }
  work.finish([] {});
  return outcomes;
}

/// What the frames depend on beside their own attributes, which a finished frame is known by.
std::string describe_frames(const RenderOptions& options, const RelightInput& input,
                            const CommonOptions& common) {
  const std::string lights =
      options.lights ? read_text_file(*options.lights, max_light_file_bytes) : std::string();
  return fmt::format("program {}\ncommand {}\ncache {:016x}\nlights {}\n", hash_program(),
                     common.command_line, input.cache->hash(), lights);
}

/// Prints a row a frame; the exit code.
int print_outcomes(const RenderOptions& options, std::span<const FrameOutcome> outcomes,
                   const CommonOptions& common) {
  std::vector<FigureRow> rows;
  std::vector<int> failed;
  int exit_code = 0;
  for (size_t i = 0; i < outcomes.size(); ++i) {
    const int frame = options.frames->first + static_cast<int>(i);
    rows.push_back({{"frame", int64_t{frame}},
                    {"output", frame_path(options.output, frame).string()},
                    {"fate", std::string(label_of(frame_fate_labels, outcomes[i].fate))},
                    {"ms", outcomes[i].ms}});
    if (outcomes[i].fate != FrameFate::failed) continue;
    if (failed.empty()) exit_code = outcomes[i].exit_code;
    failed.push_back(frame);
  }
  print_figures("relume-render-frames-1", common, rows);
  if (!failed.empty()) {
    fmt::print(stderr, "relume: {} of {} frames failed: {}\n", failed.size(), rows.size(),
               fmt::join(failed, ", "));
  }
  return exit_code;
}

}  // namespace

bool shares_render(const RenderOptions& options) {
  return options.frames.has_value();
}

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
  FrameMaker maker(options, input);
  const FrameRange range = *options.frames;
  if (!is_shared(options.output, common.team)) {
    return print_outcomes(options, make_frames(maker, range, common), common);
  }
  SharedWork work(work_folder(options.output), describe_frames(options, input, common),
                  common.team);
  const auto outcomes = make_frames_together(maker, range, work, common);
  // The others have told what failed, frame by frame.
  return common.team.rank == 0 ? print_outcomes(options, outcomes, common) : 0;
}

}  // namespace relume

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/samples/geometry_hash.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/relight_input.h"
#include "viewer/frames/compare_frame.h"
#include "viewer/frames/frame_header.h"

namespace relume {
namespace {

void check_can_verify(const FrameHeader& header, const std::string& place) {
  if (header.shadow == ShadowMethod::automatic) {
    throw input_error(place, "its shadows were chosen by measured times (--shadow auto)",
                      "render with a shadow method by name");
  }
  if (is_supported(header.instruction_set)) return;
  throw input_error(place,
                    fmt::format("made with {}, which this processor lacks",
                                label_of(instruction_set_labels, header.instruction_set)),
                    "verify it on such a processor");
}

RelightInput open_frame_input(const VerifyOptions& options, const FrameHeader& header,
                              const CommonOptions& common) {
  CommonOptions same_seed = common;
  same_seed.seed = header.seed;
  const std::string input = options.cache ? options.cache->string() : header.scene_file;
  if (options.cache && !is_cache_path(input)) {
    throw Error(ErrorKind::usage, input + ": give the .relume cache that the frame was made from");
  }
  return open_input(input, header.prepare, header.shadow != ShadowMethod::none, same_seed);
}

/// Throws Error(input) where records or geometry are not what the frame was made from.
void check_input(const VerifyOptions& options, const FrameHeader& header,
                 const RelightInput& input) {
  const std::string place = options.frame.string();
  const std::string hash = fmt::format("{:016x}", input.cache->hash());
  if (hash != header.cache_hash) {
    throw input_error(place,
                      options.cache
                          ? fmt::format("made from another cache: {}, not {} ({})",
                                        header.cache_hash, hash, options.cache->string())
                          : fmt::format("{} was prepared again, to another cache: {}, not {}",
                                        header.scene_file, hash, header.cache_hash),
                      options.cache ? "give the cache it was made from"
                                    : "give the cache it was made from, or put the scene back");
  }
  if (header.geometry_hash.empty()) return;
  if (fmt::format("{:016x}", geometry_hash(*input.scene)) == header.geometry_hash) return;
  throw input_error(place, "the scene's geometry, which casts the shadows, has changed",
                    "put the scene's files back");
}

std::optional<FrameDifference> find_difference(const VerifyOptions& options,
                                               const FrameHeader& header,
                                               const RelightInput& input) {
  const auto shadows =
      input.tracer ? make_shadow(header.shadow, *input.tracer, *input.cache) : nullptr;
  RelightState state = make_relight_state(*input.cache);
  relight(state, header.lights, shadows.get(), {.instruction_set = header.instruction_set});
  const FrameRecipe recipe{.shadow = header.shadow,
                           .shadows = shadows.get(),
                           .scene = input.scene.get(),
                           .instruction_set = header.instruction_set,
                           .aovs = header.aovs};
  return compare_frame(options.frame, make_frame_layers(state, recipe));
}

}  // namespace

int run_verify(const VerifyOptions& options, const CommonOptions& common) {
  const FrameHeader header = read_frame_header(options.frame);
  check_can_verify(header, options.frame.string());
  const RelightInput input = open_frame_input(options, header, common);
  check_input(options, header, input);
  const auto difference = find_difference(options, header, input);
  FigureRow row = {{"frame", options.frame.string()},
                   {"cache_hash", header.cache_hash},
                   {"channels", static_cast<int64_t>(header.channels.size())},
                   {"differing_values", int64_t{0}}};
  if (difference) {
    row.back().second = static_cast<int64_t>(difference->values);
    row.push_back({"channel", difference->channel});
    row.push_back({"x", int64_t{difference->x}});
    row.push_back({"y", int64_t{difference->y}});
    row.push_back({"found", double{difference->found}});
    row.push_back({"expected", double{difference->expected}});
    row.push_back({"largest_difference", difference->largest});
  }
  print_figures("relume-verify-1", common, {row});
  return difference ? 1 : 0;
}

}  // namespace relume

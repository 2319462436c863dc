#include "viewer/session/render_command.h"

#include <fmt/format.h>

#include <filesystem>

#include "core/samples/relight_cache.h"
#include "viewer/frames/frame_layers.h"

namespace relume {
namespace {

bool is_cache(const std::string& input) {
  return std::filesystem::path(input).extension() == ".relume";
}

/// What is rendered, and how it is prepared: a cache as it is, or the scene.
std::vector<std::string> input_arguments(const SessionFile& origin, const Session& session) {
  const bool all_samples = shows_all_samples(session);
  if (is_cache(origin.input) && !all_samples) return {origin.input};
  std::vector<std::string> arguments{origin.input};
  PrepareOptions prepare = origin.prepare;
  if (is_cache(origin.input)) {
    // A cache holds no samples: they come from the scene that it was made from.
    arguments[0] = scene_input(session.cache()->info());
    prepare.width = session.info().width;
    prepare.height = session.info().height;
  }
  if (all_samples) {
    arguments.emplace_back("--reference");
    prepare.records.reset();
    prepare.members.reset();
    prepare.budget = {};
    prepare.predict_error = false;
    prepare.method = PrepareOptions{}.method;
  }
  for (std::string& flag : prepare_flags(prepare, origin.seed)) arguments.push_back(flag);
  return arguments;
}

}  // namespace

bool shows_all_samples(const Session& session) {
  const SessionStatus& status = session.status();
  return status.painted == ShownPicture::reference || status.refined;
}

std::string render_command(const SessionFile& origin, const Session& session,
                           const std::string& lights, const std::string& output) {
  const ViewState& view = session.view();
  std::vector<std::string> arguments{"relume", "render"};
  for (std::string& argument : input_arguments(origin, session)) arguments.push_back(argument);
  arguments.insert(arguments.end(), {"--lights", lights});
  if (!shows_all_samples(session)) {
    arguments.insert(arguments.end(),
                     {"--shadow", std::string(label_of(shadow_method_labels, view.shadows))});
  }
  arguments.insert(arguments.end(), {"--exposure", fmt::format("{}", view.display.exposure)});
  arguments.insert(arguments.end(),
                   {"--curve", std::string(label_of(tone_curve_labels, view.display.curve))});
  arguments.insert(arguments.end(), {"-o", output});
  std::string command;
  for (const std::string& argument : arguments) {
    if (!command.empty()) command += ' ';
    command += shell_quoted(argument);
  }
  return command;
}

}  // namespace relume

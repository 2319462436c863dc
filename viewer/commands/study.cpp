#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/study_files.h"
#include "viewer/commands/study_methods.h"
#include "viewer/commands/study_names.h"
#include "viewer/commands/study_pictures.h"
#include "viewer/commands/study_shadows.h"
#include "viewer/commands/study_stability.h"
#include "viewer/commands/study_tradeoff.h"
#include "viewer/commands/work_settings.h"
#include "viewer/farm/shared_work.h"

namespace relume {
namespace {

std::vector<std::string> own_scenes(const std::string& study) {
  if (study == "stability") return {"hair", "spheres"};
  if (study == "smooth") return {"spheres"};
  if (study == "rates" || study == "lights" || study == "tradeoff" || study == "pictures")
    return {"hair", "plants"};
  return {"hair", "plants", "spheres"};
}

template <class E, size_t N>
std::string list_labels(const std::vector<E>& values, const std::array<Label<E>, N>& labels) {
  std::string text;
  for (const E value : values) text += std::string(label_of(labels, value)) + " ";
  return text;
}

/// All that a study's figures depend on, as text.
std::string describe_settings(const StudyOptions& o, const CommonOptions& common) {
  std::string text = fmt::format(
      "program {}\nstudy {} seed {} quick {}\nmethods {}\nshadows {}\nrecords {}\n", hash_program(),
      o.name, common.seed, o.quick, list_labels(o.methods, reduction_method_labels),
      list_labels(o.shadows, shadow_method_labels), fmt::join(o.records, " "));
  text += fmt::format("timed {} pictures {}\n", o.timed, o.pictures);
  text += fmt::format(
      "budgets {}\nlights {} training {} {}\nspp {} truth {}\nsize {} {} stride {} window {}\n",
      fmt::join(o.average_records, " "), o.lights, o.training_lights, o.train_shadows, o.spp,
      o.truth_spp, o.width, o.height, o.tile_stride, o.window);
  for (const std::string& name : o.scenes) {
    text += fmt::format("scene {} {}\n", name, load_scene(name, shader_table(), {}).text);
  }
  return text;
}

StudyResult measure(const StudyOptions& options, const CommonOptions& common, TrialLog& log) {
  if (options.name == "tradeoff") return run_tradeoff_study(options, common, log);
  if (options.name == "stability") return run_stability_study(options, common, log);
  if (options.name == "shadows") return run_shadow_study(options, common, log);
  if (options.name == "pictures" || options.name == "smooth") {
    return run_picture_study(options, common, log);
  }
  return run_method_study(options, common, log);
}

TrialLog open_log(const StudyOptions& options, const CommonOptions& common) {
  if (!options.output) return {};
  const std::filesystem::path log = *options.output / (options.name + ".trials");
  const std::string settings = describe_settings(options, common);
  if (!shares_study(options) || !is_shared(log, common.team)) return {log, settings};
  return {log, settings, std::make_unique<SharedWork>(work_folder(log), settings, common.team)};
}

void run_one(StudyOptions options, const CommonOptions& common) {
  if (options.page_only) {
    if (!options.output) throw Error(ErrorKind::usage, "--page-only needs -o FOLDER");
    return write_study_page(*options.output, options.name);
  }
  if (options.scenes.empty()) options.scenes = own_scenes(options.name);
  TrialLog log = open_log(options, common);
  if (log.resumed() > 0 && !common.quiet) {
    fmt::print(stderr, "{}: goes on after {} parts of an earlier run\n", options.name,
               log.resumed());
  }
  const StudyResult result = measure(options, common, log);
  if (common.json) fmt::print("{}", format_study(result, common));
  log.finish([&] {
    if (options.output) write_study(*options.output, result, common);
  });
}

}  // namespace

bool shares_study(const StudyOptions& options) {
  constexpr std::array shared = {"methods", "rates", "lights", "stability"};
  return options.output && !options.timed && !options.page_only &&
         std::ranges::find(shared, options.name) != shared.end();
}

int run_study(const StudyOptions& options, const CommonOptions& common) {
  if (options.output) make_folder(*options.output);
  if (options.name != "all") {
    run_one(options, common);
    return 0;
  }
  for (const StudyName& study : study_names) {
    if (study.name == "all") continue;
    StudyOptions one = options;
    one.name = study.name;
    run_one(one, common);
  }
  return 0;
}

}  // namespace relume

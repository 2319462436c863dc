#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>
#include <iostream>
#include <sstream>

#include "core/base/check.h"
#include "core/base/error.h"
#include "core/base/mapped_file.h"
#include "core/base/parallel.h"
#include "core/base/progress.h"
#include "core/scene/channel_map.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/program_pages.h"
#include "viewer/commands/study_names.h"
#include "viewer/commands/version.h"

namespace relume {
namespace {

/// An option that takes one of an enum's labels.
template <class E, size_t N>
CLI::Option* add_label(CLI::App& app, const std::string& name, E& value,
                       const std::array<Label<E>, N>& labels, const std::string& help) {
  const auto parse = [&value, &labels](const std::string& text) {
    const std::optional<E> found = value_of(labels, text);
    if (!found) throw CLI::ValidationError("'" + text + "' is not one of " + label_list(labels));
    value = *found;
  };
  return app.add_option_function<std::string>(name, parse, help + ": " + label_list(labels))
      ->default_str(std::string(label_of(labels, value)));
}

/// One that may be left out.
template <class E, size_t N>
CLI::Option* add_label(CLI::App& app, const std::string& name, std::optional<E>& value,
                       const std::array<Label<E>, N>& labels, const std::string& help) {
  const auto parse = [&value, &labels](const std::string& text) {
    value = value_of(labels, text);
    if (!value) throw CLI::ValidationError("'" + text + "' is not one of " + label_list(labels));
  };
  return app.add_option_function<std::string>(name, parse, help + ": " + label_list(labels));
}

/// An option that takes several of an enum's labels.
template <class E, size_t N>
void add_labels(CLI::App& app, const std::string& name, std::vector<E>& values,
                const std::array<Label<E>, N>& labels, const std::string& help) {
  const auto parse = [&values, &labels](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      const std::optional<E> found = value_of(labels, text);
      if (!found) throw CLI::ValidationError("'" + text + "' is not one of " + label_list(labels));
      values.push_back(*found);
    }
  };
  app.add_option_function<std::vector<std::string>>(name, parse, help)->delimiter(',');
}

void add_common(CLI::App& app, CommonOptions& common) {
  app.add_option("--threads", common.threads, "threads to use; 0 = all")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
  app.add_option("--seed", common.seed, "seed of all random numbers")->capture_default_str();
  app.add_flag("-q,--quiet", common.quiet, "no progress");
  app.add_flag("-v,--verbose", common.verbose, "say more on stderr");
  app.add_flag("--json", common.json, "print figures as JSON");
}

void add_prepare(CLI::App& app, PrepareOptions& options) {
  app.add_option("--spp", options.spp, "samples per pixel taken")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  add_label(app, "--method", options.method, reduction_method_labels, "reduction method");
  app.add_option("--records", options.records,
                 "records per pixel kept (k); default 8, at most 16 under a budget")
      ->check(CLI::Range(1, 64));
  app.add_option("--average-records", options.budget.average_records,
                 "budget: every pixel its own k, so many on average")
      ->check(CLI::Range(0.01, 64.0));
  app.add_option("--target-error", options.budget.target_error,
                 "budget: as few records as keep the predicted error to this fraction of the "
                 "picture's mean")
      ->check(CLI::Range(1e-6, 1.0));
  app.add_option("--members", options.members,
                 "samples that a record remembers, for shadow rays from more than one of them; "
                 "default 0, or 255 (all) with --shadow members or coverage")
      ->check(CLI::Range(0, max_members));
  app.add_flag("--predict-error", options.predict_error,
               "store a map of predicted error (light-fit and budgets always do)");
  add_label(app, "--format", options.format, cache_format_labels,
            "how records are stored: some 60, 20 or 16 bytes each; default: exact, or chosen for "
            "--target-error or a time");
  app.add_option("--training-lights", options.training_lights,
                 "random lights that light metrics are trained on (l)")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  app.add_flag("--train-shadows", options.train_shadows, "train with traced shadows");
  add_label(app, "--preset", options.preset, reduction_preset_labels,
            "report-faithful: TR2007-600 to the letter, 200 lights with shadows");
  app.add_option("--width", options.width, "pixels; 0 = the scene's")->check(CLI::Range(0, 16384));
  app.add_option("--height", options.height, "pixels; 0 = the scene's")
      ->check(CLI::Range(0, 16384));
}

/// "640x480" and the like.
std::vector<PictureSize> parse_sizes(const std::vector<std::string>& texts) {
  std::vector<PictureSize> sizes;
  for (const std::string& text : texts) {
    PictureSize size;
    char rest = 0;
    const int found = std::sscanf(text.c_str(), "%dx%d%c", &size.width, &size.height, &rest);
    const auto is_length = [](int pixels) { return pixels >= 1 && pixels <= 16384; };
    if (found != 2 || !is_length(size.width) || !is_length(size.height)) {
      throw CLI::ValidationError("--size: '" + text + "' is not WIDTHxHEIGHT, 1 to 16384 each");
    }
    sizes.push_back(size);
  }
  return sizes;
}

using Command = std::function<int()>;

/// What parsing leaves behind: the options of every command and the one that was named.
struct Parsed {
  CommonOptions common;
  DemoOptions demo;
  ViewOptions view;
  PrepareCommandOptions prepare;
  RenderOptions render;
  SampleOptions sample;
  ConvertOptions convert;
  VerifyOptions verify;
  CompareOptions compare;
  BenchOptions bench;
  InfoOptions info;
  StudyOptions study;
  Command command;
  std::function<bool()> is_shared;  ///< may be empty: it is not
};

CLI::App& add_command(CLI::App& app, Parsed& parsed, const std::string& name,
                      const std::string& help, const std::string& examples, const Command& command,
                      const std::function<bool()>& is_shared = {}) {
  CLI::App& sub = *app.add_subcommand(name, help);
  sub.footer("Examples:\n" + examples);
  sub.callback([&parsed, command, is_shared] {
    parsed.command = command;
    parsed.is_shared = is_shared;
  });
  add_common(sub, parsed.common);
  return sub;
}

void add_demo(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(app, p, "demo",
                              "Make the hair scene, prepare it and open the window, or write "
                              "pictures where there is no display",
                              "  relume demo\n  relume demo --offscreen out --scene plants",
                              [&p] { return run_demo(p.demo, p.common); });
  sub.add_option("--scene", p.demo.scene, "hair, plants, spheres or a scene file")
      ->capture_default_str();
  sub.add_option("--offscreen", p.demo.offscreen, "write pictures into this folder");
  add_prepare(sub, p.demo.prepare);
}

void add_view(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "view", "Open the interactive window on a scene or cache",
      "  relume view scenes/real/ponytail.json\n  relume view hair --offscreen out --script "
      "drag.txt",
      [&p] { return run_view(p.view, p.common); });
  sub.add_option("input", p.view.input, "scene label, scene file or .relume cache")->required();
  sub.add_option("--offscreen", p.view.offscreen, "no display: draw with OSMesa into this folder");
  sub.add_option("--frame-ms", p.view.frame_ms,
                 "slower frames are coarse first, a quarter of the pixels; 0 = never; default 40. "
                 "A scene also gets the records and the format whose shading fits")
      ->check(CLI::Range(0.0, 1e6));
  sub.add_flag("--keep-records", p.view.keep_records,
               "do not replace the picture at rest by all samples with traced shadows");
  sub.add_option("--scale", p.view.scale,
                 "size of text and controls, 1 = 96 dpi; 0 = as the display asks for")
      ->check(CLI::IsMember({0.0}) | CLI::Range(0.5, 4.0))
      ->capture_default_str();
  sub.add_option("--script", p.view.script, "scripted input (docs/viewer-scripts.md)");
  add_label(sub, "--shadow", p.view.shadow, shadow_method_labels,
            "shadow method, default auto in a window and ray in scripts");
  add_prepare(sub, p.view.prepare);
}

void add_prepare_command(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "prepare", "Sample and reduce a scene into a .relume cache",
      "  relume prepare hair -o hair.relume --records 4\n"
      "  relume prepare hair -o hair.relume --frame-ms 10\n"
      "  relume prepare hair -o hair.relume --target-error 0.02\n"
      "  relume prepare aovs.exr --channels cycles --samples 5 --proxy "
      "tree.json -o tree.relume",
      [&p] { return run_prepare(p.prepare, p.common); },
      [&p] { return shares_prepare(p.prepare); });
  sub.add_option("scene", p.prepare.scene,
                 "scene label or file; with --channels an AOV image (EXR)")
      ->required();
  CLI::Option* channels =
      sub.add_option("--channels", p.prepare.channels,
                     "take another renderer's samples; where they are in its image: " +
                         fmt::format("{}", fmt::join(channel_preset_names(), ", ")) +
                         ", or a channel map (docs/aov-input.md)");
  sub.add_option("--samples", p.prepare.samples_per_side,
                 "sub-pixels of a pixel's side in the AOV image")
      ->check(CLI::Range(1, 32))
      ->capture_default_str()
      ->needs(channels);
  sub.add_option(
         "--proxy", p.prepare.proxy,
         "scene that gives the AOV image camera, lights and what casts the shadows; without "
         "it the camera follows from the positions and the samples cast the shadows")
      ->needs(channels);
  sub.add_option("-o,--output", p.prepare.output, "cache to write")->required();
  sub.add_option("--frame-ms", p.prepare.prepare.frame_ms,
                 "choose records and format so that moving one light takes so long at most")
      ->check(CLI::Range(0.01, 1e6));
  add_label(sub, "--shadow", p.prepare.prepare.frame_shadows, shadow_method_labels,
            "shadow method that --frame-ms pays for");
  add_prepare(sub, p.prepare.prepare);
}

void add_sample(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "sample", "Write a scene's samples as a flat AOV image, one a sub-pixel (EXR)",
      "  relume sample hair --samples 5 -o aovs.exr\n  relume prepare aovs.exr --channels relume "
      "--samples 5 --proxy hair -o hair.relume",
      [&p] { return run_sample(p.sample, p.common); });
  sub.add_option("scene", p.sample.scene, "scene label or file")->required();
  sub.add_option("-o,--output", p.sample.output, "image to write (EXR)")->required();
  sub.add_option("--samples", p.sample.samples_per_side, "sub-pixels of a pixel's side")
      ->check(CLI::Range(1, 32))
      ->capture_default_str();
  sub.add_option("--width", p.sample.width, "pixels; 0 = the scene's")->check(CLI::Range(0, 16384));
  sub.add_option("--height", p.sample.height, "pixels; 0 = the scene's")
      ->check(CLI::Range(0, 16384));
}

void add_render(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "render", "Relight off-screen into an EXR with one layer per light, or a PNG",
      "  relume render hair -o frame.exr\n  relume render hair.relume --lights night.json -o "
      "night.png\n  relume render hair --reference -o reference.exr\n  relume render hair --lights "
      "turn.json --frames 1-96 -o turn.####.exr",
      [&p] { return run_render(p.render, p.common); }, [&p] { return shares_render(p.render); });
  RenderOptions& o = p.render;
  sub.add_option("input", o.input, "scene label, scene file or .relume cache")->required();
  sub.add_option("-o,--output", o.output, "picture to write: .exr or .png")->required();
  sub.add_option("--lights", o.lights, "lights to use instead of the scene's (JSON)");
  sub.add_option_function<std::string>(
      "--frames", [&o](const std::string& text) { o.frames = parse_frame_range(text); },
      "render a range of frames, FIRST-LAST, under animated lights; '####' in the output's name "
      "becomes the frame. EXR frames that are there already are kept (docs/frame-format.md)");
  sub.add_flag("--reference", o.reference, "all samples, traced shadows");
  add_label(sub, "--shadow", o.shadow, shadow_method_labels, "shadow method");
  sub.add_option("--exposure", o.exposure, "stops, for PNG; default: the scene's");
  add_label(sub, "--curve", o.curve, tone_curve_labels,
            "tone curve, for PNG; default: the display of $OCIO, srgb without one");
  sub.add_option("--predicted-error", o.predicted_error,
                 "write the predicted error of each pixel in false colour (PNG)");
  sub.add_option("--record-map", o.record_map,
                 "write the records of each pixel in false colour (PNG)");
  add_labels(
      sub, "--aov", o.aovs, frame_aov_labels,
      "write these beside the light (EXR; docs/frame-format.md): " + label_list(frame_aov_labels));
  add_label(sub, "--isa", o.instruction_set, instruction_set_labels, "instruction set");
  add_prepare(sub, o.prepare);
}

void add_convert(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "convert",
      "Write records, or with --method all samples, as a deep EXR, or lights as UsdLux",
      "  relume convert hair.relume deep.exr\n  relume convert hair samples.exr --method all\n"
      "  relume convert hair rig.usda",
      [&p] { return run_convert(p.convert, p.common); });
  ConvertOptions& o = p.convert;
  sub.add_option("input", o.input, "scene label, scene file or .relume cache")->required();
  sub.add_option("output", o.output, ".exr (deep) or .usda to write")->required();
  sub.add_option("--lights", o.lights, "lights to use instead of the scene's (JSON)");
  add_label(sub, "--shadow", o.shadow, shadow_method_labels, "shadow method");
  add_prepare(sub, o.prepare);
}

void add_verify(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "verify",
      "Render an EXR frame again as its header says and compare it bit for bit; exit code 1 and "
      "the first difference where it is not the same",
      "  relume verify frame.exr\n  relume verify frame.exr hair.relume",
      [&p] { return run_verify(p.verify, p.common); });
  sub.add_option("frame", p.verify.frame, "frame that relume render wrote (EXR)")->required();
  sub.add_option("cache", p.verify.cache,
                 "cache that it was made from; default: its scene is prepared again");
}

void add_compare(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "compare", "Print how far an image is from a reference (TR2007-600 eq. 7 and more)",
      "  relume compare frame.exr reference.exr --heatmap error.png --fail 0.01",
      [&p] { return run_compare(p.compare, p.common); });
  sub.add_option("image", p.compare.image, "image")->required();
  sub.add_option("reference", p.compare.reference, "reference")->required();
  sub.add_option("--heatmap", p.compare.heatmap, "write the error in false colour (PNG)");
  sub.add_option("--range", p.compare.range, "error at the top of the heatmap; 0 = automatic")
      ->check(CLI::Range(0.0, 1e30));
  sub.add_option("--fail", p.compare.fail, "exit with 1 when eq. 7 is above")
      ->check(CLI::Range(0.0, 1e30));
}

void add_bench(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "bench", "Time the stages, each beside its floor measured in the same run",
      "  relume bench hair --records 8 --json\n  relume bench hair.relume --frames\n"
      "  relume bench k8.relume average3.relume --frames\n"
      "  relume bench plants --frames --size 3840x2160",
      [&p] { return run_bench(p.bench, p.common); });
  sub.add_option("inputs", p.bench.inputs,
                 "scene label, file or cache; several caches: each against the first")
      ->capture_default_str();
  sub.add_option("--repeats", p.bench.repeats, "runs of each, the least counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub.add_flag("--frames", p.bench.frames_only, "time relighting alone, without shadows");
  sub.add_option("--port-cycles", p.bench.port_cycles,
                 "cycles of the kernels from tests/bench/port_cycles.py");
  sub.add_option_function<std::vector<std::string>>(
      "--size", [&p](const auto& texts) { p.bench.sizes = parse_sizes(texts); },
      "frames of this size, for instance 3840x2160, against 1280x720, both with 3 records a pixel "
      "on average unless told otherwise");
  add_prepare(sub, p.bench.prepare);
}

void add_info(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(app, p, "info", "Say what a scene, cache or image holds",
                              "  relume info hair\n  relume info hair.relume --json",
                              [&p] { return run_info(p.info, p.common); });
  sub.add_option("input", p.info.input, "scene, cache or image")->required();
}

void add_study(CLI::App& app, Parsed& p) {
  CLI::App& sub = add_command(
      app, p, "study", "Measure speed against accuracy over methods, scenes and budgets",
      "  relume study all --quick -o out\n  relume study methods scenes/real/fur.json --methods "
      "kmeans strong-kmeans light-fit -o out",
      [&p] { return run_study(p.study, p.common); }, [&p] { return shares_study(p.study); });
  StudyOptions& o = p.study;
  std::string studies = "one of";
  for (const StudyName& study : study_names) {
    studies += fmt::format("\n{}: {}", study.name, study.help);
  }
  sub.add_option("name", o.name, studies)->required()->check([](const std::string& name) {
    return find_study(name) != nullptr ? "" : "'" + name + "' is no study";
  });
  sub.add_option("scenes", o.scenes, "scene labels or files; default: the study's own");
  sub.add_option(
      "-o,--output", o.output,
      "folder for NAME.json, NAME.csv, NAME.html; a study that was stopped goes on there");
  sub.add_flag("--quick", o.quick, "minutes: 16 lights and a part of each picture");
  add_labels(sub, "--methods", o.methods, reduction_method_labels,
             "reduction methods; default: the study's own");
  add_labels(sub, "--shadows", o.shadows, shadow_method_labels,
             "shadow methods; default: none and ray, shadows: all");
  sub.add_option("--records", o.records,
                 "records per pixel (k); default: 8, rates and shadows 8 4 2")
      ->check(CLI::Range(1, 64));
  sub.add_option("--average-records", o.average_records,
                 "budgets of light-fit; 0 = none; default: 3, rates 4 3 2")
      ->check(CLI::Range(0.0, 64.0));
  sub.add_option("--lights", o.lights, "test lights; 0 = 50, quick 16")->check(CLI::Range(0, 4096));
  sub.add_option("--training-lights", o.training_lights, "lights that light metrics are trained on")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  sub.add_flag("--train-shadows", o.train_shadows, "train with traced shadows");
  sub.add_option("--spp", o.spp, "samples per pixel in")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  sub.add_option("--truth-spp", o.truth_spp,
                 "compare with an independent picture of so many samples; 0 = with all samples in, "
                 "shadows, tradeoff: 256")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  sub.add_option("--width", o.width, "pixels; 0 = the scene's")->check(CLI::Range(0, 16384));
  sub.add_option("--height", o.height, "pixels; 0 = the scene's")->check(CLI::Range(0, 16384));
  sub.add_option("--window", o.window,
                 "shadow study: measure so many pixels a side; 0 = the picture, quick 96")
      ->check(CLI::Range(0, 16384));
  sub.add_flag("--timed", o.timed,
               "methods: how long each reduces; shadows: time light moves of the whole picture");
  sub.add_flag("--pictures", o.pictures, "shadow study: write maps of visibility, side by side");
  sub.add_flag("--page-only", o.page_only,
               "measure nothing: make NAME.html of the NAME.json and the pictures in the folder");
  sub.add_option("--tile-stride", o.tile_stride, "measure every n-th tile; 0 = all, quick a part")
      ->check(CLI::Range(0, 1 << 20));
}

OptionDescription describe(const CLI::Option& option) {
  const bool has_value = option.get_items_expected_max() > 0;
  return {.names = option.get_positional() ? std::vector{option.get_name(true)}
                                           : CLI::detail::split(option.get_name(false, true), ','),
          .help = option.get_description(),
          .initial = option.get_default_str(),
          .is_positional = option.get_positional(),
          .has_value = has_value};
}

ProgramDescription describe(const CLI::App& app) {
  ProgramDescription program{app.get_description(), app.get_footer(), {}};
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    CommandDescription& command = program.commands.emplace_back();
    command.name = sub->get_name();
    command.help = sub->get_description();
    command.examples = sub->get_footer();
    for (const CLI::Option* option : sub->get_options()) {
      command.options.push_back(describe(*option));
    }
  }
  return program;
}

/// Commands that print what all the others say of themselves.
void add_pages(CLI::App& app, Parsed& p) {
  add_command(app, p, "manual", "Print the manual page (roff)", "  relume manual | man -l -",
              [&app] {
                fmt::print("{}", format_manual(describe(app)));
                return 0;
              });
  add_command(app, p, "completion", "Print the completion script for bash",
              "  source <(relume completion)", [&app] {
                fmt::print("{}", format_bash_completion(describe(app)));
                return 0;
              });
}

/// Settles who does the command. False: another process does all of it.
bool takes_part(Parsed& parsed, const Team& team) {
  if (team.is_alone()) return true;
  const bool is_shared = parsed.is_shared && parsed.is_shared();
  if (is_shared) {
    parsed.common.team = team;
    if (parsed.common.threads == 0) parsed.common.threads = share_of_processors(team);
    if (team.rank > 0) parsed.common.quiet = true;
    return true;
  }
  if (team.rank == 0) {
    fmt::print(stderr, "relume: {} processes, but nothing here to share: one does it\n", team.size);
  }
  return team.rank == 0;
}

int run_parsed(Parsed& parsed, const Team& team) {
  if (!takes_part(parsed, team)) return 0;
  set_thread_count(parsed.common.threads);
  install_interrupt_handler();
  install_mapping_guard();
  const int code = parsed.command();
  if (parsed.common.verbose) fmt::print(stderr, "{}", rare_events());
  return code;
}

constexpr size_t longest_message = 800;  // of what cannot be parsed, in bytes

/// All that the program takes.
struct CommandLine {
  CLI::App app{"Relume: moves lights through final-quality hair and foliage in real time",
               "relume"};
  Parsed parsed;

  CommandLine() {
    app.set_version_flag("--version", fmt::format("relume {} ({})", relume_version, relume_commit));
    app.require_subcommand(1);
    app.footer(
        "Exit codes: 0 ok, 1 compared images differ, 2 usage, 3 input, 4 limit, 5 output, "
        "130 interrupted");
    add_demo(app, parsed);
    add_view(app, parsed);
    add_prepare_command(app, parsed);
    add_render(app, parsed);
    add_sample(app, parsed);
    add_convert(app, parsed);
    add_verify(app, parsed);
    add_compare(app, parsed);
    add_bench(app, parsed);
    add_info(app, parsed);
    add_study(app, parsed);
    add_pages(app, parsed);
  }
};

/// A first word that is no command: CLI11 would only say that one is needed.
void check_command(const CLI::App& app, int argc, const char* const* argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->check_name(argv[1])) return;
    names.push_back(command->get_name());
  }
  throw Error(ErrorKind::usage, fmt::format("\"{}\" is no command; there are {} (relume --help)",
                                            printable(argv[1], 100), fmt::join(names, ", ")));
}

/// Parses, then calls use(parsed); returns its exit code or tells the error and returns that one's.
template <class Use>
int parse_command_line(CommandLine& line, int argc, const char* const* argv, std::ostream& out,
                       std::ostream& errors, const Use& use) {
  auto& [app, parsed] = line;
  for (int i = 1; i < argc; ++i) {
    parsed.common.command_line += printable(argv[i], 1 << 12) + '\n';
  }
  Team team;
  try {
    team = team_from_environment();
    listen_only(team);
    check_command(app, argc, argv);
    app.parse(argc, argv);
    return use(parsed, team);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error, out, errors);
    errors << printable(error.what(), longest_message)
           << "\nRun with --help for more information.\n";
    return static_cast<int>(ErrorKind::usage);
  } catch (const Error& error) {
    const std::string rank = team.rank > 0 ? fmt::format("rank {}: ", team.rank) : "";
    errors << fmt::format("relume: {}{}\n", rank, error.what());
    return error.exit_code();
  } catch (const std::bad_alloc&) {
    errors << "relume: out of memory; use fewer records, samples or pixels\n";
    return static_cast<int>(ErrorKind::limit);
  }
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CommandLine line;
  return parse_command_line(line, argc, argv, std::cout, std::cerr, run_parsed);
}

std::string check_command_line(int argc, const char* const* argv) {
  static CommandLine line;  // takes milliseconds to make
  line.parsed = {};         // nothing of the command lines before
  std::ostringstream out;
  std::ostringstream errors;
  const int code = parse_command_line(line, argc, argv, out, errors,
                                      [](const Parsed&, const Team&) { return 0; });
  if (code == 0) return {};
  const std::string told = errors.str();
  return told.substr(0, told.find('\n'));
}

}  // namespace relume

// Measures the viewer as a person feels it. Drawing by OpenGL is left out, but for bringing the
// picture to the texture: see LiveWindow.
//
// Usage: bench_viewer latency [SCENE] [MOVES]
//        bench_viewer soak JSON [MINUTES] [SCENE] [LIGHTS]
//
// latency: from an input of the mouse that moves a light to its picture on the screen, 512 x 512
// with 3 records a pixel on average, with the percentiles of MOVES (200) moves, for some ways to
// cast shadows. soak: MINUTES (20) of work without a pause, told in hours of a person who makes
// an edit every 12 seconds. With LIGHTS the scene's lights are copied until there are so many, the
// copies without shadows, and the picture at rest is not refined. What memory did goes to JSON;
// exits with 1 where it grew by more than 1 %.

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/display_soak.h"
#include "viewer/commands/version.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

using test::LiveWindow;

constexpr int side = 512;  // pixels
constexpr float average_records = 3;
constexpr double frame_s = 1.0 / 60;
constexpr double hours_per_edit = 12.0 / 3600;
constexpr double stall_ms = 100;
constexpr double largest_growth = 0.01;

PrepareParams bench_params() {
  PrepareParams params;
  params.budget.average_records = average_records;
  params.reduction.records = 16;
  params.width = params.height = side;
  return params;
}

std::unique_ptr<FrameSource> make_reference(const Tracer& tracer,
                                            const ProgressCallback& progress) {
  PrepareParams all = bench_params();
  all.budget = {};
  all.reduction.method = ReductionMethod::all;
  return make_cache_source(prepare_in_memory(tracer.scene(), tracer, all, progress), &tracer,
                           ShadowMethod::ray);
}

/// Opens a cache of prepare_cache().
OpenedInput open_cache(const SessionFile& file, const ProgressCallback&, PreparePreview&) {
  RelightCache cache = RelightCache::open(file.input, shader_table());
  auto scene = std::make_unique<const Scene>(
      parse_scene(cache.info().scene_text, cache.info().scene_file, shader_table()));
  auto tracer = std::make_unique<const Tracer>(*scene);
  OpenedInput opened;
  opened.session.reset(new Session(
      make_session(std::move(scene), std::move(tracer), std::move(cache), std::nullopt)));
  opened.session->view().refine = true;
  opened.make_reference = [&session = *opened.session](const ProgressCallback& progress) {
    return make_reference(*session.tracer(), progress);
  };
  return opened;
}

std::string prepare_cache(const std::string& input, const std::filesystem::path& path) {
  const Scene scene = load_scene(input, shader_table());
  const Tracer tracer(scene);
  prepare_to_file(scene, tracer, bench_params(), path, make_terminal_progress(false));
  return path.string();
}

/// Moves the light and waits for its picture, again and again.
std::vector<double> measure_latency(LiveWindow& window, Workspace& workspace, int moves) {
  const Session& session = *workspace.session();
  const vec2 from = window.center("handle.1");
  window.point_at(from);
  window.press();
  std::vector<double> latency_ms;
  for (int i = 1; i <= moves; ++i) {
    const uint64_t before = session.picture().version;
    const Timer timer;
    window.point_at(from + vec2(i % 80, i % 47));
    while (session.picture().version == before) {
      window.wait_for_news(1);
      window.frame();
    }
    latency_ms.push_back(timer.ms());
    workspace.wait(false);  // what is left of this move is not the next one's
    window.frame();
  }
  window.release();
  return latency_ms;
}

void print_percentiles(const std::string& name, const std::vector<double>& ms) {
  fmt::print("{:<28} p50 {:7.2f}   p95 {:7.2f}   p99 {:7.2f}   max {:7.2f} ms\n", name,
             test::percentile(ms, 0.5), test::percentile(ms, 0.95), test::percentile(ms, 0.99),
             test::percentile(ms, 1));
}

int run_latency(const std::string& scene, int moves) {
  const test::TemporaryFolder folder;
  const std::string cache = prepare_cache(scene, folder.file("bench.relume"));
  Workspace workspace(open_cache, cache, {.state_folder = folder.path()});
  workspace.wait(true);
  workspace.require_session();
  LiveWindow window(workspace);
  fmt::print("{}, {}x{}, {} records a pixel on average: from input to new picture\n", scene, side,
             side, average_records);
  ViewState& view = workspace.session()->view();
  view.refine = false;
  for (const ShadowMethod method :
       {ShadowMethod::none, ShadowMethod::automatic, ShadowMethod::ray}) {
    view.shadows = method;
    workspace.wait(true);
    for (int i = 0; i < 5; ++i) window.frame();
    measure_latency(window, workspace, std::min(20, moves));
    workspace.wait(true);
    window.frame();
    print_percentiles("shadows " + std::string(label_of(shadow_method_labels, method)),
                      measure_latency(window, workspace, moves));
    workspace.wait(true);
  }
  return 0;
}

std::vector<double> times_of(const std::vector<test::FrameTime>& frames, auto&& value) {
  std::vector<double> times;
  for (const test::FrameTime& frame : frames) times.push_back(value(frame));
  return times;
}

size_t count_stalls(const std::vector<double>& ms) {
  return static_cast<size_t>(
      std::count_if(ms.begin(), ms.end(), [](double time) { return time > stall_ms; }));
}

void print_frames(const std::vector<test::FrameTime>& frames) {
  const auto wall = times_of(frames, [](const auto& frame) { return frame.wall_ms; });
  const auto own = times_of(frames, [](const auto& frame) {
    return frame.wall_ms - frame.queued_ms;  // computing, or blocked by ourselves
  });
  const auto processor = times_of(frames, [](const auto& frame) { return frame.processor_ms; });
  fmt::print("frames of the window's thread: {}\n", frames.size());
  print_percentiles("  wall", wall);
  print_percentiles("  without the wait for a core", own);
  print_percentiles("  processor", processor);
  fmt::print("stalls above {} ms: {} by wall, {} without the wait for a core\n", stall_ms,
             count_stalls(wall), count_stalls(own));
}

void print_memory(const test::SoakFigures& figures) {
  fmt::print("{:5} edits   allocated {:.2f} MB, after the warm-up {:.2f} MB: {:+.2f} %\n",
             figures.edits, 1e-6 * figures.last_bytes, 1e-6 * figures.first_bytes,
             100 * figures.growth());
  std::fflush(stdout);
}

/// Copies the lights, each a little further, until there are `count`.
void add_lights(ViewState& view, size_t count) {
  const size_t first_count = view.lights.size();
  for (size_t i = first_count; i < count; ++i) {
    Light light = view.lights[i - first_count];
    light.name = fmt::format("light {}", i + 1);
    light.position += vec3(0.01f, 0.02f, 0.01f);
    light.gain *= 0.9f;
    light.casts_shadow = false;
    view.lights.push_back(light);
  }
}

int run_soak(const std::string& path, double minutes, const std::string& scene,
             size_t light_count) {
  const test::TemporaryFolder folder;
  std::vector<std::string> caches{prepare_cache(scene, folder.file("bench.relume"))};
  Workspace workspace(open_cache, caches.front(), {.state_folder = folder.path()});
  workspace.wait(true);
  workspace.require_session();
  if (light_count > 0) {
    workspace.session()->view().refine = false;
    add_lights(workspace.session()->view(), light_count);
    caches.clear();  // opening it again would bring the scene's own lights
    workspace.wait(true);
  }
  LiveWindow window(workspace, frame_s);
  window.times().reserve(static_cast<size_t>(60 * minutes / frame_s));  // our log does not grow
  test::SoakParams params;
  params.seconds = 60 * minutes;
  params.report = print_memory;
  const Timer timer;
  const test::SoakFigures figures = test::soak(window, workspace, caches, folder.path(), params);
  print_memory(figures);
  print_frames(window.times());
  const size_t lights = workspace.session()->view().lights.size();
  fmt::print("{} lights\n", lights);
  fmt::print("{:.1f} minutes; at an edit every 12 s these are {:.1f} hours\n", timer.seconds() / 60,
             figures.edits * hours_per_edit);
  std::ofstream(path) << nlohmann::ordered_json{{"schema", "relume-soak-1"},
                                                {"version", relume_version},
                                                {"commit", relume_commit},
                                                {"scene", scene},
                                                {"side", side},
                                                {"lights", lights},
                                                {"minutes", timer.seconds() / 60},
                                                {"edits", figures.edits},
                                                {"first_bytes", figures.first_bytes},
                                                {"last_bytes", figures.last_bytes},
                                                {"growth", figures.growth()}}
                             .dump(1)
                      << '\n';
  return figures.growth() > largest_growth ? 1 : 0;
}

int run(int count, char** arguments) {
  const auto argument = [&](int index, const char* otherwise) {
    return std::string(count > index ? arguments[index] : otherwise);
  };
  const std::string mode = argument(1, "");
  if (mode == "latency") return run_latency(argument(2, "hair"), std::stoi(argument(3, "200")));
  if (mode == "soak") {
    return run_soak(argument(2, "soak.json"), std::stod(argument(3, "20")), argument(4, "hair"),
                    std::stoul(argument(5, "0")));
  }
  fmt::print(
      stderr,
      "usage: bench_viewer latency [SCENE] [MOVES] | soak JSON [MINUTES] [SCENE] [LIGHTS]\n");
  return 2;
}

}  // namespace
}  // namespace relume

int main(int count, char** arguments) {
  try {
    return relume::run(count, arguments);
  } catch (const std::exception& failure) {
    fmt::print(stderr, "{}\n", failure.what());
    return 1;
  }
}

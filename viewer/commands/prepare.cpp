#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/timer.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/aovs/aov_reader.h"
#include "viewer/aovs/splat_proxy.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/json_output.h"
#include "viewer/commands/process_memory.h"
#include "viewer/commands/relight_input.h"
#include "viewer/commands/work_settings.h"
#include "viewer/farm/shared_work.h"

namespace relume {
namespace {

/// What was planned for a goal, and, of a time, what came out.
void add_plan(const std::optional<FramePlan>& plan, const PrepareParams& params,
              const RelightInput& input, const RelightCache& cache, FigureRow& figures) {
  if (!plan) return;
  figures.push_back({"planned_average_records", plan->average_records});
  figures.push_back({"planned_error", plan->error});
  if (params.frame_ms > 0) {
    const auto shadows = params.frame_shadows == ShadowMethod::none
                             ? nullptr
                             : make_shadow(params.frame_shadows, *input.tracer, cache);
    figures.push_back({"planned_ms_move", plan->move_ms});
    figures.push_back({"ms_move", measure_move_ms(cache, shadows.get())});
  }
  if (plan->is_met) return;
  fmt::print(stderr, "relume: {}: nothing meets that goal; the cache is as near as it gets\n",
             cache.info().scene_name);
}

/// The proxy with another renderer's samples of its view.
struct AovInput {
  RelightInput input;
  std::shared_ptr<const AovSamples> samples;
  SampleSource source;
};

AovInput open_aovs(const PrepareCommandOptions& options, const CommonOptions& common,
                   PrepareParams& params) {
  if (params.budget.is_set() || params.frame_ms > 0 || params.width > 0 || params.height > 0 ||
      params.reduction.method == ReductionMethod::pure) {
    throw Error(ErrorKind::usage,
                "--channels: an AOV image takes no budget, time, size or --method pure");
  }
  const ProgressCallback progress = make_terminal_progress(common.quiet);
  const ChannelMap map = load_channel_map(options.channels, shader_table());
  std::optional<Scene> proxy;
  if (!options.proxy.empty()) proxy = load_scene(options.proxy, shader_table(), progress);
  const auto samples =
      std::make_shared<AovSamples>(options.scene, map, options.samples_per_side,
                                   proxy ? std::optional(proxy->camera) : std::nullopt);
  if (!proxy) {
    const std::filesystem::path made = write_splat_proxy(*samples, options.output);
    fmt::print(
        stderr,
        "relume: {}: no --proxy: the camera follows from the positions, and the samples cast "
        "the shadows: what the view does not see casts none. Lights and camera are in {}\n",
        options.scene, made.string());
    samples->cast_own_shadows();
    proxy = load_scene(made.string(), shader_table(), progress);
  }
  Scene scene = std::move(*proxy);
  AovInput result;
  result.samples = samples;
  result.samples->add_materials(scene);
  result.input.scene = std::make_unique<const Scene>(std::move(scene));
  result.input.tracer = std::make_unique<const Tracer>(*result.input.scene);
  result.source = result.samples->source();
  params.spp = result.samples->spp();
  params.width = result.samples->width();
  params.height = result.samples->height();
  return result;
}

/// Alone, or with the other processes of the launcher. False for those that leave the rest to the
/// first.
bool make_cache(const PrepareCommandOptions& options, const CommonOptions& common,
                const PrepareParams& params, const RelightInput& input, PrepareStats& stats) {
  const ProgressCallback progress = make_terminal_progress(common.quiet);
  if (!shares_prepare(options) || !is_shared(options.output, common.team)) {
    prepare_to_file(*input.scene, *input.tracer, params, options.output, progress, &stats);
    return true;
  }
  SharedWork work(work_folder(options.output), describe_work(common, *input.scene), common.team);
  prepare_together(*input.scene, *input.tracer, params, options.output, work, progress, &stats);
  return common.team.rank == 0;
}

}  // namespace

bool shares_prepare(const PrepareCommandOptions& options) {
  return options.channels.empty() && !(options.prepare.frame_ms > 0);
}

int run_prepare(const PrepareCommandOptions& options, const CommonOptions& common) {
  const Timer timer;
  PrepareParams params = make_prepare_params(options.prepare, common);
  AovInput aovs;
  if (!options.channels.empty()) {
    aovs = open_aovs(options, common, params);
    params.source = &aovs.source;
  }
  const RelightInput input =
      params.source ? std::move(aovs.input) : open_scene(options.scene, common);
  PrepareStats stats;
  if (!make_cache(options, common, params, input, stats)) return 0;
  const double prepare_ms = timer.ms();
  const uint64_t peak_bytes = peak_memory_bytes();
  const RelightCache cache = RelightCache::open(options.output, shader_table());
  const CacheInfo& info = cache.info();
  const auto stored = static_cast<double>(cache.size_bytes());
  FigureRow figures{
      {"scene", info.scene_name},
      {"method", info.method},
      {"format", std::string(label_of(cache_format_labels, info.format))},
      {"records", int64_t{info.records}},
      {"spp", int64_t{info.spp}},
      {"width", int64_t{info.width}},
      {"height", int64_t{info.height}},
      {"ms_prepare", prepare_ms},
      {"ms_tracer", input.tracer->stats().build_ms},
      {"sample_count", static_cast<int64_t>(info.sample_count)},
      {"record_count", static_cast<int64_t>(info.record_count)},
      {"cache_bytes", static_cast<int64_t>(cache.size_bytes())},
      {"bytes_per_record", stored / static_cast<double>(std::max<uint64_t>(1, info.record_count))},
      {"peak_bytes", static_cast<int64_t>(peak_bytes)},
      {"peak_over_stored", static_cast<double>(peak_bytes) / stored}};
  // Processes that leave the end to another do not know what all of them took.
  if (stats.samples > 0) {
    figures.push_back({"thread_ms_sample", stats.sample_ms});
    figures.push_back({"thread_ms_reduce", stats.reduce_ms});
    figures.push_back({"thread_ms_pack", stats.pack_ms});
  }
  add_plan(stats.plan, params, input, cache, figures);
  print_figures("relume-prepare-1", common, {figures});
  return 0;
}

}  // namespace relume

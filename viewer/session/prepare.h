#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "core/base/progress.h"
#include "core/samples/relight_cache.h"
#include "core/samples/sample_scene.h"
#include "core/trace/tracer.h"
#include "reduction/budget.h"
#include "reduction/reduction.h"
#include "reduction/training.h"
#include "viewer/farm/shared_work.h"
#include "viewer/session/frame_planning.h"

namespace relume {

/// Samples of the view that something else than our ray tracer took.
struct SampleSource {
  /// Tile `index` of the view with PrepareParams::spp samples a pixel, as sample_tile gives it.
  std::function<SampleTile(const ViewSampler& view, int index)> tile;
  Bounds bounds;  ///< of their positions, world
};

/// From a scene to records, tile by tile: sample -> reduce -> pack.
struct PrepareParams {
  int spp = 25;  ///< samples per pixel, [1, 1024]; method pure takes `records` instead
  ReductionParams reduction;
  /// With an average budget, when > 0: the cost that meets it, known from a forecast.
  float record_cost = 0;
  RecordBudget budget;      ///< when set, reduction.records is the most that a pixel may have
  TrainingParams training;  ///< used by methods that need it
  /// Nothing: chosen for frame_ms or a target error, else exact.
  std::optional<CacheFormat> format;
  float frame_ms = 0;  ///< > 0: records and format are chosen, `budget` is not set; see FrameGoal
  ShadowMethod frame_shadows = ShadowMethod::none;  ///< FrameGoal::shadows
  int width = 0;                                    ///< pixels; 0 = the scene's
  int height = 0;                                   ///< pixels; 0 = the scene's
  const SampleSource* source = nullptr;  ///< null: the scene is traced; set: no budget, no frame_ms
  /// Called with the records of each tile, from working threads, in any order; may be empty.
  std::function<void(const ViewSampler& view, const SampleTile& records)> on_tile;
};

struct PrepareStats {
  double sample_ms = 0;  ///< time of each stage, summed over threads
  double reduce_ms = 0;
  double pack_ms = 0;
  uint64_t samples = 0;
  uint64_t records = 0;
  std::optional<FramePlan> plan;  ///< where records and format were chosen
};

/// What plans for times and errors are chosen from, for a scene that `params` prepares. Its budget,
/// format and frame_ms do not matter.
FrameForecast forecast_scene(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                             const ProgressCallback& progress);

/// Prepares into memory.
RelightCache prepare_in_memory(const Scene& scene, const Tracer& tracer,
                               const PrepareParams& params, const ProgressCallback& progress,
                               PrepareStats* stats = nullptr);

/// Prepares into a file, streaming: memory does not grow with the image. Nothing appears at `path`
/// before it is complete.
void prepare_to_file(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                     const std::filesystem::path& path, const ProgressCallback& progress,
                     PrepareStats* stats = nullptr);

/// The same bytes, made together with all processes of `work`; returns when the file is there. The
/// stages are counted over all of them. Not for frame_ms, which is measured, nor on_tile.
void prepare_together(const Scene& scene, const Tracer& tracer, const PrepareParams& params,
                      const std::filesystem::path& path, SharedWork& work,
                      const ProgressCallback& progress, PrepareStats* stats = nullptr);

}  // namespace relume

#include "viewer/session/record_planning.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "reduction/pixel_reducer.h"
#include "viewer/session/method_training.h"

namespace relume {
namespace {

/// Enough for a standard error of about one in a hundred of an average; pixels, background
/// included.
constexpr int planning_pixels = 16384;

/// Tiles between two reports of progress.
constexpr size_t batch_tiles = 128;

/// Error curves of `count` random pixels of tile `index`, or all it has, that have samples.
std::vector<ErrorCurve> tile_curves(const ViewSampler& view, const ReductionParams& reduction,
                                    const ReductionLights& lights, int index, int count) {
  const TileRectangle tile = tile_rectangle(view, index);
  PixelReducer reducer(view.types.types, reduction, lights);
  Random random(reduction.seed, RandomStream::planning, static_cast<uint64_t>(index));
  std::vector<ErrorCurve> curves;
  const int pixels = tile.width * tile.height;
  const int runs = std::min(count, pixels);
  for (int i = 0; i < runs; ++i) {
    // One pixel of each of `runs` equal runs of the tile's pixels.
    const int first = i * pixels / runs;
    const int last = (i + 1) * pixels / runs;
    const int pixel = first + static_cast<int>(random.below(static_cast<uint32_t>(last - first)));
    const int x = tile.x0 + pixel % tile.width;
    const int y = tile.y0 + pixel / tile.width;
    const SampleTile samples = sample_one_pixel(view, x, y);
    reducer.load(samples, 0, static_cast<uint64_t>(y) * static_cast<uint64_t>(view.width) + x);
    if (reducer.sample_count() > 0) curves.push_back(reducer.error_curve(0));
  }
  return curves;
}

}  // namespace

float plan_record_cost(const Scene& scene, const ViewSampler& view,
                       const ReductionParams& reduction, const TrainingParams& training,
                       const RecordBudget& budget, const ProgressCallback& callback) {
  ReductionParams params = reduction;
  params.predict_error = true;
  const auto lights = make_method_lights(scene, view, params, training);
  const auto tiles = static_cast<size_t>(tile_count(view));
  const int per_tile = std::max(1, static_cast<int>(planning_pixels / static_cast<int64_t>(tiles)));
  std::vector<std::vector<ErrorCurve>> curves(tiles);
  Progress progress(callback, "plan records of " + scene.name);
  for (size_t first = 0; first < tiles; first += batch_tiles) {
    const size_t count = std::min(batch_tiles, tiles - first);
    parallel_for(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = first + begin; i < first + end; ++i) {
        curves[i] = tile_curves(view, params, lights->lights(), static_cast<int>(i), per_tile);
      }
    });
    progress.update(static_cast<double>(first + count), static_cast<double>(tiles));
  }
  std::vector<ErrorCurve> all;
  for (std::vector<ErrorCurve>& tile : curves) {
    std::move(tile.begin(), tile.end(), std::back_inserter(all));
  }
  return solve_record_cost(all, budget);
}

}  // namespace relume

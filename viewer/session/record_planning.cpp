#include "viewer/session/record_planning.h"

#include <algorithm>
#include <limits>

#include "core/base/check.h"
#include "core/base/parallel.h"
#include "reduction/pixel_reducer.h"
#include "viewer/session/method_training.h"

namespace relume {
namespace {

/// Where records cost nothing at all, pixels still take no more than help them.
constexpr float smallest_cost = std::numeric_limits<float>::min();

/// At most so many pixels, for a standard error of about one in a hundred of an average; of small
/// views a part, but enough for two in a hundred. Background included.
constexpr int64_t most_planning_pixels = 16384;
constexpr int64_t least_planning_pixels = 4096;
constexpr int64_t planning_part = 8;

/// Enough to know the cost to a factor.
constexpr int64_t pilot_pixels = 512;
constexpr float pilot_margin = 4;

/// Pixels between two reports of progress.
constexpr int64_t batch_pixels = 1024;

/// Error curves of `count` random pixels, one of each of `count` equal runs of the view's pixels,
/// exact for any cost of a record that is not below `cost`. Pixels without samples have none.
/// `covered_part` comes out as in RecordPlan.
std::vector<ErrorCurve> sample_curves(const ViewSampler& view, const ReductionParams& reduction,
                                      const ReductionLights& lights, int64_t count, float cost,
                                      Progress& progress, double& covered_part) {
  const int64_t pixels = int64_t{view.width} * view.height;
  const int64_t runs = std::min(count, pixels);
  std::vector<ErrorCurve> curves(static_cast<size_t>(runs));
  for (int64_t begin = 0; begin < runs; begin += batch_pixels) {
    const int64_t batch = std::min(batch_pixels, runs - begin);
    parallel_for(static_cast<size_t>(batch), 16, [&](size_t low, size_t high) {
      PixelReducer reducer(view.types.types, reduction, lights);
      for (size_t i = low; i < high; ++i) {
        const int64_t run = begin + static_cast<int64_t>(i);
        const int64_t first = run * pixels / runs;
        const int64_t last = (run + 1) * pixels / runs;
        Random random(reduction.seed, RandomStream::planning, static_cast<uint64_t>(first));
        const int64_t pixel = first + random.below(static_cast<uint32_t>(last - first));
        const SampleTile samples = sample_one_pixel(view, static_cast<int>(pixel % view.width),
                                                    static_cast<int>(pixel / view.width));
        reducer.load(samples, 0, static_cast<uint64_t>(pixel));
        if (reducer.sample_count() > 0) curves[run] = reducer.error_curve(cost);
      }
    });
    progress.update(static_cast<double>(begin + batch), static_cast<double>(runs));
  }
  std::erase_if(curves, [](const ErrorCurve& curve) { return curve.errors.empty(); });
  covered_part = static_cast<double>(curves.size()) / static_cast<double>(runs);
  return curves;
}

}  // namespace

RecordPlan plan_records(const Scene& scene, const ViewSampler& view,
                        const ReductionParams& reduction, const TrainingParams& training,
                        const RecordBudget& budget, const ProgressCallback& callback) {
  CHECK(budget.is_set());
  ReductionParams params = reduction;
  params.predict_error = true;
  const auto lights = make_method_lights(scene, view, params, training);
  // A few whole curves tell the cost to a factor; then most pixels need only their curves' starts.
  Progress pilot(callback, "plan records of " + scene.name);
  RecordPlan plan;
  float least_cost = solve_record_cost(
      sample_curves(view, params, lights->lights(), pilot_pixels, 0, pilot, plan.covered_part),
      budget);
  const int64_t count = std::clamp(int64_t{view.width} * view.height / planning_part,
                                   least_planning_pixels, most_planning_pixels);
  do {
    least_cost = least_cost > smallest_cost ? least_cost / pilot_margin : 0;
    Progress progress(callback, "plan records of " + scene.name);
    plan.curves = sample_curves(view, params, lights->lights(), count, least_cost, progress,
                                plan.covered_part);
    plan.record_cost = solve_record_cost(plan.curves, budget);
  } while (plan.record_cost < least_cost);
  plan.record_cost = std::max(plan.record_cost, smallest_cost);
  return plan;
}

}  // namespace relume

#include "viewer/commands/bench_edits.h"

#include <fmt/format.h>

#include "viewer/commands/bench_time.h"
#include "viewer/commands/process_memory.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

constexpr double most_layer_bytes = 6.0 * (1 << 30);

double layer_bytes(const CacheInfo& info, int lights) {
  return 3.0 * sizeof(float) * info.width * info.height * lights;
}

/// `edit` of many lights against one light that moves.
FigureRow edit_row(const std::string& name, RepeatedFrame& one, int repeats,
                   const std::function<void()>& edit) {
  const std::vector<double> ms = least_ms_in_turn(repeats, {[&] { one.move_all(); }, edit});
  return {{"name", name}, {"ms", ms[1]}, {"ratio", ms[1] / ms[0]}};
}

FigureRow drag_row(const RelightCache& cache, RepeatedFrame& one, int lights, int repeats) {
  const auto before = static_cast<int64_t>(allocated_bytes());
  RepeatedFrame many(cache, lights);
  const auto bytes = static_cast<int64_t>(allocated_bytes()) - before;
  const std::vector<double> ms =
      least_ms_in_turn(repeats, {[&] { one.drag_one(); }, [&] { many.drag_one(); }});
  return {{"name", fmt::format("drag-of-{}", lights)},
          {"ms", ms[1]},
          {"ratio", ms[1] / ms[0]},
          {"state_bytes", bytes}};
}

FigureRow first_frame_row(const RelightCache& cache, RepeatedFrame& one, int lights) {
  RepeatedFrame many(cache, lights);
  const double ms = least_ms(1, [&] { many.start_again(); });
  const double one_ms = least_ms(3, [&] { one.move_all(); });
  return {{"name", fmt::format("first-frame-{}", lights)}, {"ms", ms}, {"ratio", ms / one_ms}};
}

}  // namespace

std::vector<FigureRow> bench_edits(const RelightCache& cache, int repeats) {
  RepeatedFrame one(cache, 1);
  RepeatedFrame many(cache, 16);
  std::vector<FigureRow> rows{
      edit_row("coarse-frame", one, repeats, [&] { one.move_all_coarsely(); }),
      edit_row("gain-16-layers", one, repeats, [&] { many.dim_one(); }),
      edit_row("gain-drag-16-layers", one, repeats, [&] { many.drag_gain(); })};
  const auto fits = [&](int n) { return layer_bytes(cache.info(), n) <= most_layer_bytes; };
  for (const int lights : {1, 16, 64, 256}) {
    if (fits(lights)) rows.push_back(drag_row(cache, one, lights, repeats));
  }
  for (const int lights : {1, 16, 64, 256}) {
    if (fits(lights)) rows.push_back(first_frame_row(cache, one, lights));
  }
  return rows;
}

}  // namespace relume

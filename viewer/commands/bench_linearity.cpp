#include "viewer/commands/bench_linearity.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

#include "viewer/commands/bench_cuts.h"
#include "viewer/commands/bench_time.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

/// Of the largest cut.
constexpr double most_records = 8e6;

/// A frame that was timed.
struct TimedFrame {
  std::string name;
  FrameWork work;
  double ms = 0;
};

/// Frames of some caches under some lights, timed in turn.
class FrameGroup {
 public:
  explicit FrameGroup(std::string what) : what_(std::move(what)) {}

  void add(const RelightCache& cache, const std::string& label, int lights, double x) {
    frames_.push_back(std::make_unique<RepeatedFrame>(cache, lights));
    names_.push_back(fmt::format("{}-{}", what_, label));
    x_.push_back(x);
  }

  /// Appends the rows of the group and what was timed.
  void time(int repeats, std::vector<FigureRow>& rows, std::vector<TimedFrame>& timed) {
    std::vector<std::function<void()>> moves;
    std::vector<std::function<void()>> dims;
    for (const auto& frame : frames_) {
      moves.emplace_back([&frame] { frame->move_all(); });
      dims.emplace_back([&frame] { frame->dim_one(); });
    }
    const std::vector<double> ms = least_ms_in_turn(repeats, moves);
    append_timed("", ms, timed);
    const LineFit line = fit_line(x_, ms);
    for (size_t i = 0; i < x_.size(); ++i) {
      const double fit_ms = line.intercept_ms + line.slope_ms * x_[i];
      rows.push_back({{"name", names_[i]},
                      {"x", x_[i]},
                      {"ms", ms[i]},
                      {"fit_ms", fit_ms},
                      {"deviation", fit_ms / ms[i] - 1}});
    }
    rows.push_back({{"name", "linear-" + what_},
                    {"intercept_ms", line.intercept_ms},
                    {"slope_ms", line.slope_ms},
                    {"largest_deviation", line.largest_deviation}});
    append_timed("-dimmed", least_ms_in_turn(repeats, dims), timed);
  }

 private:
  void append_timed(const std::string& suffix, const std::vector<double>& ms,
                    std::vector<TimedFrame>& timed) const {
    for (size_t i = 0; i < ms.size(); ++i) {
      timed.push_back({names_[i] + suffix, frames_[i]->work(), ms[i]});
    }
  }

  std::string what_;
  std::vector<std::unique_ptr<RepeatedFrame>> frames_;
  std::vector<std::string> names_;
  std::vector<double> x_;
};

double covered_pixels(const RelightCache& cache) {
  double count = 0;
  for (const float coverage : cache.coverage()) count += coverage > 0 ? 1 : 0;
  return count;
}

void bench_records(const RelightCache& cache, int repeats, std::vector<FigureRow>& rows,
                   std::vector<TimedFrame>& timed) {
  constexpr int most = 16;
  const int tile_rows = tile_rows_for(cache.info(), most_records, most);
  std::vector<RelightCache> cuts;
  FrameGroup group("records");
  for (int k = 1; k <= most; k *= 2) cuts.push_back(cut_cache(cache, {k, tile_rows}));
  for (const RelightCache& cut : cuts) {
    const double x = static_cast<double>(cut.info().record_count) / covered_pixels(cut);
    group.add(cut, fmt::format("{:.0f}", x), 1, x);
  }
  group.time(repeats, rows, timed);
}

void bench_pixels(const RelightCache& cache, int repeats, std::vector<FigureRow>& rows,
                  std::vector<TimedFrame>& timed) {
  const double average = static_cast<double>(cache.info().record_count) / covered_pixels(cache);
  const int records = std::max(1, static_cast<int>(std::lround(average)));
  const int all_rows = (cache.info().height + tile_size - 1) / tile_size;
  const int most_rows = std::min(all_rows, tile_rows_for(cache.info(), most_records, records));
  std::vector<RelightCache> cuts;
  for (const int part : {4, 2, 1}) {
    cuts.push_back(cut_cache(cache, {records, std::max(1, most_rows / part)}));
  }
  FrameGroup group("pixels");
  for (const RelightCache& cut : cuts) {
    group.add(cut, fmt::format("{}x{}", cut.info().width, cut.info().height), 1,
              covered_pixels(cut));
  }
  group.time(repeats, rows, timed);
}

void bench_lights(const RelightCache& cache, int repeats, std::vector<FigureRow>& rows,
                  std::vector<TimedFrame>& timed) {
  FrameGroup group("lights");
  for (const int lights : {1, 2, 4, 8, 16})
    group.add(cache, std::to_string(lights), lights, lights);
  group.time(repeats, rows, timed);
}

/// Every third frame is predicted from the others.
void bench_cost(const std::vector<TimedFrame>& timed, std::vector<FigureRow>& rows) {
  FrameCost cost;
  for (size_t i = 0; i < timed.size(); ++i) {
    if (i % 3 != 1) cost.add_measurement(timed[i].work, timed[i].ms);
  }
  double least = std::numeric_limits<double>::infinity();
  double largest = 0;
  std::vector<FigureRow> predictions;
  for (size_t i = 1; i < timed.size(); i += 3) {
    const double predicted_ms = cost.predict_ms(timed[i].work);
    const double ratio = predicted_ms / timed[i].ms;
    least = std::min(least, ratio);
    largest = std::max(largest, ratio);
    predictions.push_back({{"name", "frame-cost-" + timed[i].name},
                           {"ms", timed[i].ms},
                           {"predicted_ms", predicted_ms},
                           {"predicted_ratio", ratio}});
  }
  rows.push_back({{"name", "frame-cost"},
                  {"frames", int64_t{cost.measurements()}},
                  {"held_out", static_cast<int64_t>(predictions.size())},
                  {"least_predicted_ratio", least},
                  {"largest_predicted_ratio", largest}});
  rows.insert(rows.end(), predictions.begin(), predictions.end());
}

}  // namespace

LineFit fit_line(const std::vector<double>& x, const std::vector<double>& ms) {
  double sums[5] = {};  // of weight times 1, x, x^2, ms, x ms
  for (size_t i = 0; i < x.size(); ++i) {
    const double weight = 1 / (ms[i] * ms[i]);
    const double terms[] = {1, x[i], x[i] * x[i], ms[i], x[i] * ms[i]};
    for (int j = 0; j < 5; ++j) sums[j] += weight * terms[j];
  }
  LineFit line;
  const double determinant = sums[0] * sums[2] - sums[1] * sums[1];
  if (!(determinant > 1e-12 * sums[0] * sums[2])) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none, none};
  }
  line.slope_ms = (sums[0] * sums[4] - sums[1] * sums[3]) / determinant;
  line.intercept_ms = (sums[2] * sums[3] - sums[1] * sums[4]) / determinant;
  for (size_t i = 0; i < x.size(); ++i) {
    const double deviation = (line.intercept_ms + line.slope_ms * x[i]) / ms[i] - 1;
    line.largest_deviation = std::max(line.largest_deviation, std::abs(deviation));
  }
  return line;
}

std::vector<FigureRow> bench_linearity(const RelightCache& cache, int repeats) {
  std::vector<FigureRow> rows;
  std::vector<TimedFrame> timed;
  bench_records(cache, repeats, rows, timed);
  bench_pixels(cache, repeats, rows, timed);
  bench_lights(cache, repeats, rows, timed);
  bench_cost(timed, rows);
  return rows;
}

}  // namespace relume

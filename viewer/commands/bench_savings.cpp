#include "viewer/commands/bench_savings.h"

#include <algorithm>

#include "viewer/commands/bench_cuts.h"
#include "viewer/commands/bench_time.h"
#include "viewer/session/repeated_frame.h"

namespace relume {
namespace {

/// Of a cut.
constexpr double most_records = 8e6;

/// Sees every light from everywhere.
class AllVisible final : public VisibilitySource {
 public:
  void prepare(const Light&) override {}
  void visibility(const Receivers& receivers, float* visibility) const override {
    std::fill_n(visibility, receivers.count, 1.0f);
  }
};

FigureRow saving_row(const std::string& name, int repeats, const std::function<void()>& own,
                     const std::function<void()>& general) {
  const std::vector<double> ms = least_ms_in_turn(repeats, {own, general});
  return {{"name", name}, {"ms", ms[0]}, {"general_ms", ms[1]}, {"ratio", ms[0] / ms[1]}};
}

FigureRow diffuse_row(const RelightCache& cache, int repeats) {
  const CacheInfo& info = cache.info();
  const double per_pixel = static_cast<double>(info.record_count) / info.width / info.height;
  const int tile_rows = tile_rows_for(info, most_records, per_pixel);
  const RelightCache lambert = make_diffuse_cache(cache, DiffuseShader::lambert, tile_rows);
  const RelightCache phong = make_diffuse_cache(cache, DiffuseShader::phong, tile_rows);
  RepeatedFrame own(lambert, 1);
  RepeatedFrame general(phong, 1);
  return saving_row(
      "only-diffuse", repeats, [&] { own.move_all(); }, [&] { general.move_all(); });
}

FigureRow shadows_row(const RelightCache& cache, int repeats) {
  AllVisible all_visible;
  RepeatedFrame own(cache, 1);
  RepeatedFrame general(cache, 1, InstructionSet::automatic, &all_visible);
  return saving_row(
      "shadows-off", repeats, [&] { own.move_all(); }, [&] { general.move_all(); });
}

FigureRow footprints_row(const RelightCache& cache, int repeats) {
  const RelightCache bare = cut_cache(cache, {});
  RepeatedFrame own(bare, 1);
  RepeatedFrame general(cache, 1);
  return saving_row(
      "without-footprints", repeats, [&] { own.move_all(); }, [&] { general.move_all(); });
}

FigureRow pass_row(const RelightCache& cache, int repeats) {
  RepeatedFrame own(cache, 4);
  RepeatedFrame general(cache, 1);
  return saving_row(
      "lights-in-one-pass", repeats, [&] { own.move_all(); },
      [&] {
        for (int i = 0; i < 4; ++i) general.move_all();
      });
}

}  // namespace

std::vector<FigureRow> bench_savings(const RelightCache& cache, int repeats) {
  std::vector<FigureRow> rows{diffuse_row(cache, repeats), shadows_row(cache, repeats),
                              pass_row(cache, repeats)};
  const CacheInfo& info = cache.info();
  if (info.has_footprints && static_cast<double>(info.record_count) <= most_records) {
    rows.push_back(footprints_row(cache, repeats));
  }
  return rows;
}

}  // namespace relume

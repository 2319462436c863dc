#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/relight/pixel_visibility.h"
#include "core/samples/pack.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

/// Visibility that can be told from the position alone.
class PositionVisibility final : public VisibilitySource {
 public:
  void prepare(const Light&) override {}
  void visibility(const Receivers& receivers, float* visibility) const override {
    for (int i = 0; i < receivers.count; ++i) visibility[i] = of(receivers.position[0][i]);
  }
  static float of(float x) { return 0.5f + 0.5f * std::clamp(x, -1.0f, 1.0f); }
};

TEST(PixelVisibility, IsTheWeightedMeanOverRecords) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 16, 16, 5, 3);
  const RelightCache cache = make_tile_cache(tile, types, {0, 0, 5});
  const std::vector<float> pixels = pixel_visibility(cache, PositionVisibility());
  int covered = 0;
  for (int pixel = 0; pixel < tile.pixel_count(); ++pixel) {
    double seen = 0;
    double weight = 0;
    for (size_t t = 0; t < types.size(); ++t) {
      const TypedRows& rows = tile.types[t];
      for (uint32_t row = rows.first[pixel]; row < rows.first[pixel + 1]; ++row) {
        const float x = rows.values[size_t{row} * types[t].width];
        seen += double{rows.weights[row]} * PositionVisibility::of(x);
        weight += rows.weights[row];
      }
    }
    if (weight > 0) ++covered;
    EXPECT_NEAR(pixels[pixel], weight > 0 ? seen / weight : 0, 1e-6) << "pixel " << pixel;
  }
  EXPECT_GT(covered, 200);
}

TEST(PixelVisibility, IsBitEqualForAnyThreadCount) {
  const Scene scene = make_plane_scene(5, vec3(0.5f), 70, 40);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  set_thread_count(1);
  const std::vector<float> one = pixel_visibility(cache, PositionVisibility());
  const uint64_t slots = query_cache(cache, PositionVisibility());
  set_thread_count(5);
  EXPECT_EQ(one, pixel_visibility(cache, PositionVisibility()));
  EXPECT_EQ(slots, query_cache(cache, PositionVisibility()));
  EXPECT_GE(16 * slots, cache.info().record_count);
  set_thread_count(0);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <atomic>

#include "core/image/metrics.h"
#include "core/relight/relight.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "shadow/shadow.h"
#include "tests/viewer/lamp_scene.h"
#include "viewer/session/prepare.h"
#include "viewer/session/prepare_preview.h"

namespace relume {
namespace {

TEST(PreparePreview, IsRoughlyTheFrame) {
  const Scene scene = load_scene("spheres", shader_table());
  const Tracer tracer(scene);
  std::atomic<int> told = 0;
  PreparePreview preview([&told] { ++told; });
  std::atomic<int> tiles = 0;
  PrepareParams params;
  params.spp = 9;
  params.reduction.records = 3;
  params.width = 72;
  params.height = 50;
  params.on_tile = [&](const ViewSampler& view, const SampleTile& records) {
    preview.add_tile(view, records);
    ++tiles;
  };
  const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
  EXPECT_EQ(tiles, 5 * 4);
  EXPECT_EQ(told, 1) << "again only when somebody looked";
  Image image;
  float exposure = 0;
  ASSERT_TRUE(preview.take(image, exposure));
  EXPECT_FALSE(preview.take(image, exposure));

  RelightState state = make_relight_state(cache);
  const auto shadows = make_shadow(ShadowMethod::ray, tracer, cache);
  relight(state, scene.lights, shadows.get());
  const ImageError error = compare_images(image, state.frame, cache.coverage());
  EXPECT_LT(error.error_covered, 0.1 * error.reference_mean)
      << "only the shadows' edges differ: one ray a pixel";
}

TEST(PreparePreview, ShowsWhatMaterialsEmit) {
  Scene scene = parse_scene(test::lamp_scene, "lamp.json", shader_table());
  scene.lights.clear();
  scene.exposure = -1.5f;
  const Tracer tracer(scene);
  PreparePreview preview;
  PrepareParams params;
  params.spp = 9;
  params.reduction.records = 3;
  params.on_tile = [&](const ViewSampler& view, const SampleTile& records) {
    preview.add_tile(view, records);
  };
  const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
  Image image;
  float exposure = 0;
  ASSERT_TRUE(preview.take(image, exposure));
  EXPECT_EQ(exposure, scene.exposure);
  EXPECT_EQ(image.pixels, cache.emission());
  EXPECT_EQ(*std::max_element(image.pixels.begin(), image.pixels.end()), 2);
}

TEST(PreparePreview, DoesNotChangeWhatIsPrepared) {
  const Scene scene = load_scene("spheres", shader_table());
  const Tracer tracer(scene);
  PrepareParams params;
  params.spp = 4;
  params.width = params.height = 40;
  const RelightCache plain = prepare_in_memory(scene, tracer, params, {});
  PreparePreview preview;
  params.on_tile = [&](const ViewSampler& view, const SampleTile& tile) {
    preview.add_tile(view, tile);
  };
  const RelightCache watched = prepare_in_memory(scene, tracer, params, {});
  RelightState states[] = {make_relight_state(plain), make_relight_state(watched)};
  for (RelightState& state : states) relight(state, scene.lights, nullptr);
  EXPECT_EQ(states[0].frame.pixels, states[1].frame.pixels);
}

}  // namespace
}  // namespace relume

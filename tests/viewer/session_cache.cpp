#include <gtest/gtest.h>

#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/session/prepare.h"
#include "viewer/session/session.h"

namespace relume {
namespace {

/// A built-in scene, small, with and without all that belongs to it.
struct Prepared {
  explicit Prepared(const char* name = "spheres")
      : scene(std::make_unique<const Scene>(load_scene(name, shader_table()))),
        tracer(std::make_unique<const Tracer>(*scene)) {}

  RelightCache prepare(ReductionMethod method) const {
    PrepareParams params;
    params.spp = 9;
    params.reduction.method = method;
    params.reduction.records = 2;
    params.width = 48;
    params.height = 40;
    return prepare_in_memory(*scene, *tracer, params, {});
  }

  std::unique_ptr<const Scene> scene;
  std::unique_ptr<const Tracer> tracer;
};

TEST(CacheSession, FrameIsTheCacheRelitWithTheViewsLights) {
  Prepared prepared;
  const RelightCache same = prepared.prepare(ReductionMethod::strong_kmeans);
  RelightState expected = make_relight_state(same);
  const auto shadows = make_shadow(ShadowMethod::ray, *prepared.tracer, same);
  RelightCache cache = prepared.prepare(ReductionMethod::strong_kmeans);
  RelightCache all = prepared.prepare(ReductionMethod::all);
  Session session = make_session(std::move(prepared.scene), std::move(prepared.tracer),
                                 std::move(cache), std::move(all));
  EXPECT_EQ(session.info().width, 48);
  EXPECT_EQ(session.info().records, 2);
  EXPECT_EQ(session.info().record_counts, same.record_counts());
  EXPECT_TRUE(session.info().has_reference);
  ASSERT_FALSE(session.view().lights.empty());
  EXPECT_EQ(session.view().selected_light, 0);
  EXPECT_EQ(session.view().shadows, ShadowMethod::ray);

  for (int move = 0; move < 3; ++move) {
    session.view().lights[0].position.x += 0.25f;
    session.wait(true);
    relight(expected, session.view().lights, shadows.get());
    EXPECT_EQ(session.frame().image.pixels, expected.frame.pixels) << "move " << move;
    EXPECT_EQ(session.frame().stats.layers_shaded,
              move == 0 ? static_cast<int>(session.view().lights.size()) : 1);
  }
  session.view().shadows = ShadowMethod::none;
  session.wait(true);
  invalidate(expected);
  relight(expected, session.view().lights, nullptr);
  EXPECT_EQ(session.frame().image.pixels, expected.frame.pixels);
  EXPECT_EQ(session.status().problem, "");
}

TEST(CacheSource, AutomaticShadowsAreQuickWhileALightIsDraggedAndFinerAtRest) {
  const Prepared prepared("hair");
  const auto source_of = [&] {
    return make_cache_source(prepared.prepare(ReductionMethod::strong_kmeans),
                             prepared.tracer.get());
  };
  const auto render = [](FrameSource& source, const RelightRequest& request) {
    RelitFrame frame;
    const std::atomic<bool> never{false};
    source.render(request, never, frame);
    return frame;
  };
  RelightRequest request{.lights = prepared.scene->lights, .shadows = ShadowMethod::automatic};
  const auto source = source_of();
  render(*source, request);
  request.lights[0].position.x += 0.5f;
  request.dragging = true;
  request.frame_ms = 1e-6f;  // nothing fits: the quickest is taken
  const RelitFrame dragged = render(*source, request);
  EXPECT_EQ(dragged.stats.layers_shaded, 1);
  EXPECT_TRUE(dragged.shadows_used.starts_with("volume")) << dragged.shadows_used;
  request.dragging = false;
  request.frame_ms = 0;
  const RelitFrame rested = render(*source, request);
  EXPECT_EQ(rested.stats.layers_shaded, 1) << "the light that was dragged, not the others";
  EXPECT_TRUE(rested.shadows_used.starts_with("coverage")) << rested.shadows_used;
  EXPECT_NE(rested.image.pixels, dragged.image.pixels);
  EXPECT_EQ(render(*source, request).stats.layers_shaded, 0) << "once";
  request.shadows = ShadowMethod::volume;
  EXPECT_EQ(render(*source, request).shadows_used, "");
}

TEST(CacheSession, HeatmapComparesWithEverySample) {
  Prepared prepared;
  const RelightCache same = prepared.prepare(ReductionMethod::strong_kmeans);
  RelightCache cache = prepared.prepare(ReductionMethod::strong_kmeans);
  RelightCache all = prepared.prepare(ReductionMethod::all);
  const RelightCache all_too = prepared.prepare(ReductionMethod::all);
  const auto shadows = make_shadow(ShadowMethod::ray, *prepared.tracer, same);
  const auto traced = make_shadow(ShadowMethod::ray, *prepared.tracer, all_too);
  RelightState frame = make_relight_state(same);
  RelightState reference = make_relight_state(all_too);
  relight(frame, prepared.scene->lights, shadows.get());
  relight(reference, prepared.scene->lights, traced.get());
  const ImageError expected = compare_images(frame.frame, reference.frame, same.coverage());

  Session session = make_session(std::move(prepared.scene), std::move(prepared.tracer),
                                 std::move(cache), std::move(all));
  session.view().shown = ShownPicture::heatmap;
  session.wait(true);
  ASSERT_TRUE(session.status().error.has_value());
  EXPECT_GT(expected.error_covered, 0);
  EXPECT_EQ(session.status().error->error_covered, expected.error_covered);
  EXPECT_EQ(session.status().error->error_image, expected.error_image);
}

TEST(CacheSession, WithoutATracerThereAreNoShadowsAndNoReference) {
  const Prepared prepared;
  Session session = make_session(nullptr, nullptr, prepared.prepare(ReductionMethod::kmeans),
                                 prepared.prepare(ReductionMethod::all));
  EXPECT_FALSE(session.info().can_trace);
  EXPECT_FALSE(session.info().has_reference);
  EXPECT_EQ(session.view().shadows, ShadowMethod::none);
  session.wait(true);
  EXPECT_EQ(session.status().problem, "");
  EXPECT_GT(session.picture().version, 0u);

  session.view().shadows = ShadowMethod::ray;
  session.wait(true);
  EXPECT_NE(session.status().problem.find("shadows"), std::string::npos)
      << session.status().problem;
  session.view().shadows = ShadowMethod::none;
  session.wait(true);
  EXPECT_EQ(session.status().problem, "");
}

}  // namespace
}  // namespace relume

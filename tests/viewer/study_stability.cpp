#include <gtest/gtest.h>

#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "viewer/study/stability_study.h"

namespace relume {
namespace {

TEST(Stability, ExtremesChangeWhatTheySay) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Bounds bounds = world_bounds(scene);
  const Scene large = make_extreme_scene(scene, bounds, Extreme::scale, 1000);
  EXPECT_NEAR(world_bounds(large).radius() / bounds.radius(), 1000, 0.01);
  EXPECT_EQ(large.lights[0].position, 1000.0f * scene.lights[0].position);
  const Scene far = make_extreme_scene(scene, bounds, Extreme::distance, 50);
  for (const Light& light : far.lights) {
    if (light.type == LightType::directional) continue;
    EXPECT_NEAR(glm::length(light.position - bounds.center()) / bounds.radius(), 50, 0.01);
  }
  const Scene bright = make_extreme_scene(scene, bounds, Extreme::intensity, 8);
  EXPECT_EQ(bright.lights[0].gain, 8 * scene.lights[0].gain);
}

TEST(Stability, PicturesDoNotDependOnTheUnitsOfTheScene) {
  const Scene scene = load_scene("spheres", shader_table(), {});
  const Tracer tracer(scene);
  TrialLog log;
  const auto figures =
      study_stability(scene, tracer, {.spp = 4, .records = 2, .width = 24, .height = 24}, log, {});
  const auto base = std::ranges::find_if(
      figures, [](const auto& f) { return f.extreme == Extreme::scale && f.value == 1; });
  ASSERT_NE(base, figures.end());
  EXPECT_GT(base->covered_pixels, 150);
  for (const StabilityFigure& figure : figures) {
    const std::string where(label_of(extreme_labels, figure.extreme));
    EXPECT_NE(figure.extreme, Extreme::thinness) << "spheres have no strands";
    EXPECT_EQ(figure.non_finite_values, 0) << where << " " << figure.value;
    EXPECT_LT(figure.error_relative, 1e-4) << where << " " << figure.value;
    if (figure.extreme != Extreme::scale) continue;
    EXPECT_NEAR(figure.visibility, base->visibility, 0.01) << figure.value;
    EXPECT_NEAR(figure.error_reduced, base->error_reduced, 0.1 * base->error_reduced);
  }
}

}  // namespace
}  // namespace relume

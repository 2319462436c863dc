#include <gtest/gtest.h>

#include "core/image/metrics.h"
#include "core/relight/relight.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "shadow/shadow.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

struct FormatBound {
  const char* scene;
  double standard;
  double compact;
};

/// What packing costs a picture of a built-in scene with shadows: TR2007-600 eq. 7 against the
/// exact format, per mean of the picture. The bounds are some 1.5 times what docs/cache-format.md
/// tells.
class CacheFormats : public testing::TestWithParam<FormatBound> {};

TEST_P(CacheFormats, StayWithinTheirErrors) {
  const Scene scene = load_scene(GetParam().scene, shader_table());
  const Tracer tracer(scene);
  const auto shadows = make_shadow(ShadowMethod::ray, tracer);
  PrepareParams params;
  params.spp = 9;
  params.reduction.method = ReductionMethod::kmeans;
  params.reduction.records = 4;
  params.width = 128;
  params.height = 96;
  const auto render = [&](CacheFormat format) {
    params.format = format;
    const RelightCache cache = prepare_in_memory(scene, tracer, params, {});
    RelightState state = make_relight_state(cache);
    relight(state, scene.lights, shadows.get());
    return std::pair(state.frame, cache.coverage());
  };
  const auto [exact, coverage] = render(CacheFormat::exact);
  const auto error = [&, &exact = exact, &coverage = coverage](CacheFormat format) {
    const ImageError measured = compare_images(render(format).first, exact, coverage);
    return measured.error_covered / measured.reference_mean;
  };
  const double standard = error(CacheFormat::standard);
  const double compact = error(CacheFormat::compact);
  RecordProperty("standard", std::to_string(standard));
  RecordProperty("compact", std::to_string(compact));
  EXPECT_GT(standard, 0);
  EXPECT_LE(standard, GetParam().standard);
  EXPECT_LE(compact, GetParam().compact);
}

INSTANTIATE_TEST_SUITE_P(Scenes, CacheFormats,
                         testing::Values(FormatBound{"hair", 0.007, 0.045},
                                         FormatBound{"plants", 0.008, 0.07},
                                         FormatBound{"spheres", 0.0013, 0.0036}),
                         [](const auto& parameter) { return std::string(parameter.param.scene); });

}  // namespace
}  // namespace relume

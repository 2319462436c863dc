#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/relight/kernel.h"
#include "core/relight/reference_relight.h"
#include "core/relight/relight.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"
#include "tests/support/response_bound.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: light and record builders

/// One light of each kernel kind at `distance` from the origin, plus narrow and wide cones.
std::vector<Light> lights_at(float distance) {
  const vec3 towards = normalize_or({0.3f, 0.5f, 0.8f}, {0, 0, 1});
  const vec3 position = distance * towards;
  Light near = make_point_light(position);
  near.range = std::max(distance, 1e-15f);
  Light near_spot = make_spot_light(position, -towards, 10, 90);
  near_spot.range = std::min(1.2f * near.range, 1e15f);
  return {make_point_light(position),
          near,
          near_spot,
          make_point_light(position, 1, false),
          make_spot_light(position, -towards, 10, 25),
          make_spot_light(position, -towards, 20, 20, false),
          make_spot_light(position, {1, -1, 0}, 0, 90),
          make_directional_light(-towards)};
}

class Kernel : public testing::TestWithParam<std::tuple<InstructionSet, size_t>> {
 protected:
  void SetUp() override {
    if (!is_supported(std::get<0>(GetParam()))) {
      GTEST_SKIP() << "this machine or build lacks the set";
    }
  }
  Image layer(const RelightCache& cache, const Light& light) {
    RelightState state = make_relight_state(cache);
    const RelightStats stats = relight(state, {&light, 1}, nullptr, {std::get<0>(GetParam())});
    EXPECT_EQ(stats.replaced_values, 0u);
    return layer_image(state, 0);
  }
};

/// One record a pixel, so that every record meets its own tolerance.
SampleTile make_single_tile(const SampleType& type, uint64_t seed) {
  SampleTile tile;
  tile.width = tile_size;
  tile.height = tile_size;
  tile.types.resize(1);
  tile.types[0].first.push_back(0);
  for (uint32_t pixel = 0; pixel < 256; ++pixel) {
    Random random(seed, RandomStream::tests, pixel);
    append_random_vector(type, random, tile.types[0].values);
    tile.types[0].weights.push_back(1);
    tile.types[0].first.push_back(pixel + 1);
  }
  return tile;
}

TEST_P(Kernel, MatchesTheReferenceForEachLight) {
  const SampleType type = all_sample_types()[std::get<1>(GetParam())];
  const vec3 eye(0.5f, -1, 4);
  int lit = 0;
  for (uint64_t seed = 0; seed < 4; ++seed) {
    const SampleTile tile = make_single_tile(type, seed);
    const RelightCache cache = make_tile_cache(tile, {type}, eye);
    for (const float distance : {0.0f, 1e-6f, 0.5f, 1.0f, 3.0f, 1e4f, 1e9f}) {
      for (const Light& light : lights_at(distance)) {
        const Image image = layer(cache, light);
        for (int pixel = 0; pixel < 256; ++pixel) {
          const float* v = &tile.types[0].values[static_cast<size_t>(pixel) * type.width];
          const ResponseBound bound = bound_response(type, v, light, dvec3(eye), 1);
          for (size_t c = 0; c < 3; ++c) {
            ASSERT_NEAR(image.rgb(pixel)[c], bound.exact[c], bound.tolerance[c])
                << type.name << " " << label_of(light_type_labels, light.type) << " falloff "
                << light.falloff << " distance " << distance << " seed " << seed << " pixel "
                << pixel;
            lit += bound.exact[c] > 0 ? 1 : 0;
          }
        }
      }
    }
  }
  EXPECT_GT(lit, 10000);
}

TEST_P(Kernel, StaysFiniteAtTheExtremes) {
  const SampleType type = all_sample_types()[std::get<1>(GetParam())];
  SampleTile tile = make_single_tile(type, 5);
  // Lights and the eye right on records, and records right at the light.
  for (int i = 0; i < 3; ++i) tile.types[0].values[i] = 0;
  for (const vec3 eye : {vec3(0), vec3(1e-20f), vec3(0, 0, 1e9f)}) {
    const RelightCache cache = make_tile_cache(tile, {type}, eye);
    for (const float distance : {0.0f, 1e-30f, 1e-6f, 1e9f, 1e15f}) {
      for (const Light& light : lights_at(distance)) {
        const Image image = layer(cache, light);
        for (const float value : image.pixels) ASSERT_TRUE(is_finite(value) && value >= 0);
      }
    }
  }
}

std::string case_name(const testing::TestParamInfo<std::tuple<InstructionSet, size_t>>& info) {
  std::string name = fmt::format("{}_{}", label_of(instruction_set_labels, std::get<0>(info.param)),
                                 shader_table()[std::get<1>(info.param)]->name);
  std::erase_if(name, [](char c) { return c == '.' || c == '-'; });
  return name;
}

INSTANTIATE_TEST_SUITE_P(
    InstructionSetsAndShaders, Kernel,
    testing::Combine(testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                     InstructionSet::avx2, InstructionSet::avx512),
                     testing::Range(size_t{0}, shader_table().size())),
    case_name);

class MixedKernel : public testing::TestWithParam<InstructionSet> {};

/// A visibility that depends on the record only: a hash of its position.
class HashedVisibility final : public VisibilitySource {
 public:
  void prepare(const Light&) override {}
  void visibility(const Receivers& receivers, float* visibility) const override {
    for (int i = 0; i < receivers.count; ++i) {
      const float x = receivers.position[0][i] * 17 + receivers.position[1][i] * 31;
      visibility[i] = x - std::floor(x);
    }
  }
};

TEST_P(MixedKernel, SumsRecordsOfAllTypesAndTheirVisibility) {
  if (!is_supported(GetParam())) GTEST_SKIP() << "this machine or build lacks the set";
  std::vector<SampleType> types = all_sample_types();
  SampleTile tile = make_random_tile(types, 13, 11, 5, 3);
  // Here the sums are tested, the conditioning is tested above.
  widen_highlights(types, tile);
  const RelightCache cache = make_tile_cache(tile, types, {0, 0, 4});
  HashedVisibility shadows;
  for (const Light& light : lights_at(2.0f)) {
    for (VisibilitySource* source :
         {static_cast<VisibilitySource*>(nullptr), static_cast<VisibilitySource*>(&shadows)}) {
      const Image exact = reference_layer(cache, light, source);
      RelightState state = make_relight_state(cache);
      relight(state, {&light, 1}, source, {GetParam()});
      float brightest = 0;
      for (const float value : exact.pixels) brightest = std::max(brightest, value);
      EXPECT_GT(brightest, 0);
      EXPECT_LE(max_difference(layer_image(state, 0), exact), 2e-5f * brightest + 1e-7f)
          << label_of(light_type_labels, light.type) << (source != nullptr ? " shadowed" : "");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, MixedKernel,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512),
                         [](const auto& parameter) {
                           return fmt::format("set{}", static_cast<int>(parameter.param));
                         });

TEST(KernelThreads, AnyThreadCountGivesTheSameBits) {
  Scene scene = make_plane_scene(1.2f, vec3(0.5f), 150, 90);
  add_material(scene, "phong");
  add_shape(scene, make_sphere({0.2f, 0.1f, 0.4f}, 0.4f, 16, 1));
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 5);
  const std::vector<Light> lights = lights_at(2.5f);
  HashedVisibility shadows;
  std::vector<float> first;
  for (const int threads : {1, 2, 3, 8}) {
    set_thread_count(threads);
    const Image frame = render_frame(cache, lights, &shadows);
    if (threads == 1) first = frame.pixels;
    EXPECT_TRUE(frame.pixels == first) << threads << " threads";
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace relume

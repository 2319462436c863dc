#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/relight/relight.h"
#include "shadow/coverage.h"
#include "shadow/shadow.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// Visibility of each receiver that is one, in the cache's order.
std::vector<float> known_visibility(const RelightCache& cache, VisibilitySource& source,
                                    const Light& light) {
  source.prepare(light);
  std::vector<float> result;
  const ViewReceivers view(cache);
  for (size_t t = 0; t < view.tile_count(); ++t) {
    view.visit_tile(t, [&](const ReceiverGroup& group) {
      float visibility[block_lanes];
      source.visibility(group.receivers, visibility);
      for (int lane = 0; lane < group.receivers.count; ++lane) {
        if (group.receivers.weight[lane] > 0) result.push_back(visibility[lane]);
      }
    });
  }
  return result;
}

double mean_of(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

void add_floor(Scene& scene) {
  const uint32_t floor = add_material(scene, "lambert");
  add_shape(scene, make_quad(vec3(0), {0, 0, 4}, {4, 0, 0}, floor));
}

/// Strands that stand on a floor, thinner than a pixel.
Scene make_meadow(int strands = 150) {
  Scene scene = make_empty_scene(make_camera({0, 2, 5}, {0, 0.2f, 0}, 40), 48, 48);
  add_floor(scene);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Random random(4, RandomStream::tests, 0);
  for (int i = 0; i < strands; ++i) {
    const float x = random.uniform(-1.2f, 1.2f);
    const float z = random.uniform(-1.2f, 1.2f);
    const float lean = random.uniform(-0.3f, 0.3f);
    add_shape(scene, make_strand({x, 0.01f, z}, {x + lean, 0.7f, z - lean}, 0.006f, 4, hair));
  }
  return scene;
}

/// Small leaves of two triangles over a floor.
Scene make_leaves(int leaves = 120) {
  Scene scene = make_empty_scene(make_camera({0, 3, 5}, {0, 0.2f, 0}, 40), 48, 48);
  add_floor(scene);
  const uint32_t leaf = add_material(scene, "leaf");
  Random random(5, RandomStream::tests, 0);
  for (int i = 0; i < leaves; ++i) {
    const float x = random.uniform(-1.2f, 1.2f);
    const float y = random.uniform(0.2f, 0.8f);
    const float z = random.uniform(-1.2f, 1.2f);
    const vec3 u = 0.06f * random_direction(random);
    const vec3 across = 0.03f * random_direction(random);
    add_shape(scene, make_quad({x, y, z}, u, across, leaf));
  }
  return scene;
}

/// A blade of 6 x 1 quads that bends over half a circle, with smooth normals.
Mesh make_blade(vec3 root, vec3 out, vec3 across, uint32_t material) {
  constexpr uint32_t steps = 6;
  Mesh mesh;
  for (uint32_t i = 0; i <= steps; ++i) {
    const float angle = pi * static_cast<float>(i) / steps;
    const vec3 up(0, glm::length(out), 0);
    const vec3 middle = root + out * (1 - std::cos(angle)) + up * std::sin(angle);
    const vec3 normal = glm::normalize(up * std::sin(angle) - out * std::cos(angle));
    for (const float side : {-1.0f, 1.0f}) {
      mesh.positions.push_back(middle + side * across);
      mesh.normals.push_back(normal);
    }
  }
  for (uint32_t i = 0; i < 2 * steps; i += 2) {
    mesh.triangles.emplace_back(i, i + 1, i + 3);
    mesh.triangles.emplace_back(i, i + 3, i + 2);
  }
  mesh.materials.assign(mesh.triangles.size(), material);
  return mesh;
}

/// Bent blades over a floor.
Scene make_blades(int blades = 60) {
  Scene scene = make_empty_scene(make_camera({0, 2, 5}, {0, 0.2f, 0}, 40), 48, 48);
  add_floor(scene);
  const uint32_t leaf = add_material(scene, "leaf");
  Random random(8, RandomStream::tests, 0);
  for (int i = 0; i < blades; ++i) {
    const float x = random.uniform(-1.2f, 1.2f);
    const float z = random.uniform(-1.2f, 1.2f);
    const float turn = random.uniform(0, 2 * pi);
    const vec3 out(std::cos(turn), 0, std::sin(turn));
    add_shape(scene, make_blade({x, 0.01f, z}, 0.15f * out, 0.04f * vec3(-out.z, 0, out.x), leaf));
  }
  return scene;
}

/// Leaves as thin as paper that are closed: two bent faces, each of 4 x 1 quads.
Scene make_leaves_with_two_faces(int leaves = 90) {
  Scene scene = make_empty_scene(make_camera({0, 3, 5}, {0, 0.2f, 0}, 40), 48, 48);
  add_floor(scene);
  const uint32_t leaf = add_material(scene, "leaf");
  Random random(6, RandomStream::tests, 0);
  for (int i = 0; i < leaves; ++i) {
    const vec3 root(random.uniform(-1.2f, 1.2f), random.uniform(0.2f, 0.8f),
                    random.uniform(-1.2f, 1.2f));
    const vec3 along = 0.1f * random_direction(random);
    const vec3 across = 0.05f * random_direction(random);
    const vec3 out = glm::normalize(glm::cross(along, across));
    Mesh mesh;
    for (const float thickness : {0.0f, 0.001f}) {
      for (uint32_t step = 0; step <= 4; ++step) {
        const float at = 0.5f * static_cast<float>(step) - 1;
        const float part = step == 0 || step == 4 ? 0 : thickness;
        const vec3 middle = root + at * along + (0.02f * (1 - at * at) + part) * out;
        mesh.positions.push_back(middle - across);
        mesh.positions.push_back(middle + across);
      }
    }
    for (uint32_t q = 0; q < 8; q += 2) {
      mesh.triangles.emplace_back(q, q + 1, q + 3);
      mesh.triangles.emplace_back(q, q + 3, q + 2);
      mesh.triangles.emplace_back(q + 10, q + 13, q + 11);
      mesh.triangles.emplace_back(q + 10, q + 12, q + 13);
    }
    for (uint32_t q = 0; q < 8; q += 2) {  // the sides
      mesh.triangles.emplace_back(q, q + 12, q + 10);
      mesh.triangles.emplace_back(q, q + 2, q + 12);
      mesh.triangles.emplace_back(q + 1, q + 11, q + 13);
      mesh.triangles.emplace_back(q + 1, q + 13, q + 3);
    }
    mesh.materials.assign(mesh.triangles.size(), leaf);
    add_shape(scene, mesh);
  }
  return scene;
}

struct NamedLight {
  const char* name;
  Light light;
};

std::vector<NamedLight> all_lights() {
  return {{"above", make_point_light({1, 4, 1.5f})},
          {"grazing", make_point_light({-4, 0.4f, 0.5f})},
          {"inside", make_point_light({0.1f, 0.35f, 0.2f})},
          {"near", make_point_light({0.02f, 0.02f, 0.9f})},
          {"far", make_point_light({3000, 9000, 4000})},
          {"directional", make_directional_light({-0.4f, -1, -0.3f})},
          {"spot", make_spot_light({0.5f, 3, 0.5f}, {-0.2f, -1, 0}, 15, 30)}};
}

TEST(Coverage, IsOneWithoutOccluders) {
  Scene scene = make_empty_scene(make_camera({0, 2, 5}, {0, 0.2f, 0}, 40), 24, 24);
  add_floor(scene);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility coverage(tracer, cache);
  for (const NamedLight& light : all_lights()) {
    for (const float v : known_visibility(cache, coverage, light.light)) {
      ASSERT_EQ(v, 1.0f) << light.name;
    }
  }
}

TEST(Coverage, OfThinGeometryIsWhatManyRaysFind) {
  for (const bool is_leaves : {false, true}) {
    const Scene scene = is_leaves ? make_leaves() : make_meadow();
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 16);
    CoverageVisibility coverage(tracer, cache);
    const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
    for (const NamedLight& light : all_lights()) {
      const std::vector<float> found = known_visibility(cache, coverage, light.light);
      const std::vector<float> traced = known_visibility(cache, *rays, light.light);
      for (const float v : found) ASSERT_TRUE(v >= 0 && v <= 1) << v << " " << light.name;
      // Next to the light, footprints are large against their distance.
      const bool is_near = light.light.position.y < 0.1f && light.light.type == LightType::point;
      EXPECT_NEAR(mean_of(found), mean_of(traced), is_near ? 0.03 : 0.012)
          << light.name << " " << is_leaves;
    }
  }
}

TEST(Coverage, BentLeavesWithSmoothNormalsShadeAsRaysDo) {
  const Scene scene = make_blades();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 16);
  CoverageVisibility coverage(tracer, cache);
  const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
  for (const vec3 place : {vec3(1, 4, 1.5f), vec3(-4, 0.9f, 0.5f), vec3(2, 1, -4), vec3(0, 2, 5)}) {
    const Light light = make_point_light(place);
    EXPECT_NEAR(mean_of(known_visibility(cache, coverage, light)),
                mean_of(known_visibility(cache, *rays, light)), 0.015)
        << place.x;
  }
}

TEST(Coverage, LeavesWithTwoFacesAreDarkWhereLitFromBehind) {
  const Scene scene = make_leaves_with_two_faces();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 16);
  CoverageVisibility coverage(tracer, cache);
  const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
  for (const vec3 place : {vec3(1, 4, 1.5f), vec3(-3, 0.9f, -2), vec3(2, 1, -4), vec3(0, 2, 5)}) {
    const Light light = make_point_light(place);
    EXPECT_NEAR(mean_of(known_visibility(cache, coverage, light)),
                mean_of(known_visibility(cache, *rays, light)), 0.012)
        << place.x;
  }
}

TEST(Coverage, DoesNotDependOnTheSceneScaleAndPlace) {
  const Scene scene = make_meadow(60);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility coverage(tracer, cache);
  for (const float scale : {1e-6f, 1e6f}) {
    Scene lit = scene;
    for (const NamedLight& light : all_lights()) lit.lights.push_back(light.light);
    const Scene moved = move_scene(lit, scale, vec3(0));
    const Tracer moved_tracer(moved);
    const RelightCache moved_cache = make_full_cache(moved, moved_tracer, 4);
    CoverageVisibility moved_coverage(moved_tracer, moved_cache);
    for (size_t l = 0; l < lit.lights.size(); ++l) {
      const std::vector<float> expected = known_visibility(cache, coverage, lit.lights[l]);
      const std::vector<float> found =
          known_visibility(moved_cache, moved_coverage, moved.lights[l]);
      EXPECT_NEAR(mean_of(found), mean_of(expected), 2e-3)
          << all_lights()[l].name << " at " << scale;
    }
  }
}

TEST(Coverage, IsTheSameForAnyThreadCount) {
  const Scene scene = make_meadow();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  for (const NamedLight& light : all_lights()) {
    std::vector<float> first;
    for (const int threads : {1, 2, 3, 8}) {
      set_thread_count(threads);
      CoverageVisibility coverage(tracer, cache);
      const std::vector<float> found = known_visibility(cache, coverage, light.light);
      if (first.empty()) first = found;
      EXPECT_EQ(found, first) << light.name << " " << threads << " threads";
    }
  }
  set_thread_count(0);
}

TEST(Coverage, OfAQuarterOfThePixelsIsThatOfAll) {
  // Of blades, coarser forms may be drawn where fewer receivers ask.
  const std::pair<Scene, double> cases[] = {{make_meadow(), 2e-4}, {make_blades(), 0.015}};
  for (const auto& [scene, most_difference] : cases) {
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 4);
    CoverageVisibility coverage(tracer, cache);
    const ViewReceivers view(cache);
    for (const NamedLight& light : all_lights()) {
      coverage.prepare(light.light);
      const std::vector<float> all(coverage.all_visibility().begin(),
                                   coverage.all_visibility().end());
      const uint64_t all_receivers = coverage.stats().receivers;
      // Another light in between: nothing of it may stay.
      coverage.prepare(make_point_light({-2, 1, -1}));
      coverage.prepare_share(light.light, PixelShare::quarter);
      EXPECT_LT(coverage.stats().receivers, all_receivers / 2 + 1) << light.name;
      double difference = 0;
      double count = 0;
      for (size_t tile = 0; tile < view.tile_count(); ++tile) {
        const auto compare = [&](const ReceiverGroup& group) {
          for (int lane = 0; lane < group.receivers.count; ++lane) {
            if (!(group.receivers.weight[lane] > 0)) continue;
            const size_t i = group.receivers.first + static_cast<size_t>(lane);
            difference += std::abs(coverage.all_visibility()[i] - all[i]);
            ++count;
          }
        };
        view.visit_tile(tile, compare, PixelShare::quarter);
      }
      EXPECT_GT(count, 0);
      EXPECT_LE(difference, most_difference * count) << light.name;
    }
  }
}

TEST(Coverage, ACoarseFrameThatIsCompletedIsTheWhole) {
  const Scene scene = make_blades();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility coverage(tracer, cache);
  for (const NamedLight& light : all_lights()) {
    const std::vector<Light> lights = {light.light};
    RelightState state = make_relight_state(cache);
    relight(state, lights, &coverage, {.pixels = PixelShare::quarter});
    relight(state, lights, &coverage, {});
    EXPECT_EQ(max_difference(state.frame, render_frame(cache, lights, &coverage)), 0) << light.name;
  }
}

TEST(Coverage, InstructionSetsAgree) {
  const Scene scene = make_leaves();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility plain(tracer, cache, InstructionSet::scalar);
  for (const InstructionSet set :
       {InstructionSet::sse42, InstructionSet::avx2, InstructionSet::avx512}) {
    if (!is_supported(set)) continue;
    CoverageVisibility fast(tracer, cache, set);
    for (const NamedLight& light : all_lights()) {
      const std::vector<float> a = known_visibility(cache, plain, light.light);
      const std::vector<float> b = known_visibility(cache, fast, light.light);
      double difference = 0;
      for (size_t i = 0; i < a.size(); ++i) difference += std::abs(double{a[i]} - b[i]);
      EXPECT_LT(difference / static_cast<double>(a.size()), 1e-4) << light.name;
    }
  }
}

TEST(Coverage, AnotherOccluderNeverBrightens) {
  const Scene fewer = make_meadow(60);
  Scene more = make_meadow(60);
  const uint32_t hair = 1;
  // Out of the camera's sight, so that the receivers stay.
  for (int i = 0; i < 40; ++i) {
    const float x = -1.5f + 0.08f * static_cast<float>(i);
    add_shape(more, make_strand({x, 2.6f, -1}, {x, 2.6f, 1}, 0.02f, 3, hair));
  }
  const Tracer tracer(fewer);
  const Tracer more_tracer(more);
  const RelightCache cache = make_full_cache(fewer, tracer, 4);
  const RelightCache same = make_full_cache(more, more_tracer, 4);
  ASSERT_EQ(cache.info().record_count, same.info().record_count);
  CoverageVisibility before(tracer, cache);
  CoverageVisibility after(more_tracer, same);
  for (const NamedLight& light : all_lights()) {
    const std::vector<float> a = known_visibility(cache, before, light.light);
    const std::vector<float> b = known_visibility(same, after, light.light);
    for (size_t i = 0; i < a.size(); ++i) ASSERT_LE(b[i], a[i] + 1e-5f) << light.name << " " << i;
  }
}

TEST(Coverage, StrandsAndLeavesDoNotShadeThemselves) {
  const auto check = [](const Scene& scene, double least) {
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 16);
    ASSERT_GT(cache.info().record_count, 50u);
    CoverageVisibility coverage(tracer, cache);
    for (const vec3 place : {vec3(1, 4, 1.5f), vec3(4, 2, 3), vec3(-3, 1.2f, 5)}) {
      const std::vector<float> found = known_visibility(cache, coverage, make_point_light(place));
      EXPECT_GE(mean_of(found), least) << place.x;
    }
  };
  Scene strand = make_empty_scene(make_camera({0, 0.5f, 3}, {0, 0.4f, 0}, 25), 48, 48);
  const uint32_t hair = add_material(strand, "kajiya-kay");
  add_shape(strand, make_strand({-0.3f, 0, 0}, {0.3f, 0.8f, 0.1f}, 0.01f, 8, hair));
  check(strand, 0.995);
  Scene leaf = make_empty_scene(make_camera({0, 0.5f, 3}, {0, 0.4f, 0}, 25), 48, 48);
  const uint32_t green = add_material(leaf, "leaf");
  add_shape(leaf, make_quad({0, 0.4f, 0}, {0.3f, 0.1f, 0}, {0, 0.2f, 0.2f}, green));
  check(leaf, 0.995);
}

TEST(Coverage, OfStraightHairIsAboutThatOfRaysToo) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 48, 48);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Random random(9, RandomStream::tests, 0);
  for (int i = 0; i < 400; ++i) {
    const vec3 out = random_direction(random);
    add_shape(scene, make_strand(out, 1.4f * out, 0.015f, 4, hair));
  }
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 16);
  CoverageVisibility coverage(tracer, cache);
  const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
  for (const vec3 place : {vec3(3, 3, 2), vec3(0, 5, 1), vec3(-4, 0.5f, 4)}) {
    const Light light = make_point_light(place);
    const std::vector<float> found = known_visibility(cache, coverage, light);
    const std::vector<float> traced = known_visibility(cache, *rays, light);
    double difference = 0;
    for (size_t i = 0; i < found.size(); ++i) {
      difference += static_cast<double>(std::abs(found[i] - traced[i]));
    }
    EXPECT_LT(difference / static_cast<double>(found.size()), 0.05) << place.x;
  }
}

TEST(Coverage, OutsideTheConeThereIsNoWork) {
  const Scene scene = make_meadow(30);
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility coverage(tracer, cache);
  const Light away = make_spot_light({0, 3, 0}, {0, 1, 0}, 10, 20);
  for (const float v : known_visibility(cache, coverage, away)) ASSERT_EQ(v, 1.0f);
  EXPECT_EQ(coverage.stats().receivers, 0u);
  EXPECT_EQ(coverage.stats().primitives, 0u);
  EXPECT_EQ(coverage.stats().rays, 0u);
  EXPECT_EQ(coverage.stats().project_ms, 0);
  EXPECT_EQ(coverage.stats().shade_ms, 0);
}

TEST(Coverage, FootprintsThatAreWideSeeFewerTriangles) {
  uint64_t last = std::numeric_limits<uint64_t>::max();
  for (const int size_px : {192, 48, 12}) {
    Scene scene = make_blades();
    scene.width = scene.height = size_px;
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 1);
    CoverageVisibility coverage(tracer, cache);
    coverage.prepare(make_point_light({1, 4, 1.5f}));
    EXPECT_LT(static_cast<double>(coverage.stats().primitives), 0.8 * static_cast<double>(last));
    last = coverage.stats().primitives;
  }
}

TEST(Coverage, OfStrandsThatPassTheLightIsTheSameEitherWayRound) {
  // From above and behind the light to below it: cut where they are level with it.
  const auto make = [](bool from_above) {
    Scene scene = make_empty_scene(make_camera({0, 3, 5}, {0, 0, 0}, 40), 32, 32);
    add_floor(scene);
    const uint32_t hair = add_material(scene, "kajiya-kay");
    for (int i = 0; i < 12; ++i) {
      const float x = -1.1f + 0.2f * static_cast<float>(i);
      const vec3 above(x, 2, -0.4f);
      const vec3 below(x, 0.05f, 0.6f);
      add_shape(scene, make_strand(from_above ? above : below, from_above ? below : above, 0.03f, 1,
                                   hair));
    }
    return scene;
  };
  const Scene down = make(true);
  const Scene up = make(false);
  const Tracer down_tracer(down);
  const Tracer up_tracer(up);
  const RelightCache down_cache = make_full_cache(down, down_tracer, 4);
  const RelightCache up_cache = make_full_cache(up, up_tracer, 4);
  CoverageVisibility down_coverage(down_tracer, down_cache);
  CoverageVisibility up_coverage(up_tracer, up_cache);
  const auto rays = make_shadow(ShadowMethod::ray, down_tracer, down_cache);
  for (const vec3 place : {vec3(0.1f, 0.8f, 0.5f), vec3(-0.6f, 1, 0.4f)}) {
    const Light light = make_point_light(place);
    const double mean = mean_of(known_visibility(down_cache, down_coverage, light));
    EXPECT_NEAR(mean_of(known_visibility(up_cache, up_coverage, light)), mean, 2e-3);
    EXPECT_NEAR(mean_of(known_visibility(down_cache, *rays, light)), mean, 0.02);
  }
}

TEST(Coverage, FarLightsAreParallel) {
  const Scene scene = make_meadow();
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  CoverageVisibility coverage(tracer, cache);
  const vec3 direction = glm::normalize(vec3(0.4f, 1, 0.3f));
  const std::vector<float> parallel =
      known_visibility(cache, coverage, make_directional_light(-direction));
  for (const float distance : {1e5f, 1e7f}) {
    const std::vector<float> far =
        known_visibility(cache, coverage, make_point_light(distance * direction));
    double difference = 0;
    for (size_t i = 0; i < far.size(); ++i) difference += std::abs(double{far[i]} - parallel[i]);
    EXPECT_LT(difference / static_cast<double>(far.size()), 2e-3) << distance;
  }
}

TEST(Coverage, SolidsShadeStrandsAndStrandsShadeSolids) {
  for (const int rings : {8, 64}) {  // few triangles are drawn, many traced
    Scene scene = make_meadow();
    const uint32_t skin = add_material(scene, "lambert");
    add_shape(scene, make_sphere({0, 1.6f, 0}, 0.7f, rings, skin));
    const Tracer tracer(scene);
    const RelightCache cache = make_full_cache(scene, tracer, 9);
    CoverageVisibility coverage(tracer, cache);
    const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
    for (const Light& light : {make_point_light({0, 5, 0.5f}), make_point_light({2, 3, 2})}) {
      EXPECT_NEAR(mean_of(known_visibility(cache, coverage, light)),
                  mean_of(known_visibility(cache, *rays, light)), 0.012)
          << rings;
      EXPECT_EQ(coverage.traces_solids(), rings == 64);
    }
  }
}

TEST(Coverage, CubeFacesLeaveNoSeams) {
  // A cloud of strands all around.
  Scene scene = make_empty_scene(make_camera({0, 0, 6}, vec3(0), 45), 64, 64);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Random random(6, RandomStream::tests, 0);
  for (int i = 0; i < 1500; ++i) {
    const vec3 out = random_direction(random);
    const vec3 across = random_direction(random);
    const vec3 middle = random.uniform(0.7f, 2.0f) * out;
    add_shape(scene,
              make_strand(middle - 0.15f * across, middle + 0.15f * across, 0.008f, 2, hair));
  }
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 9);
  CoverageVisibility coverage(tracer, cache);
  const auto rays = make_shadow(ShadowMethod::ray, tracer, cache);
  const Light light = make_point_light(vec3(0));
  const std::vector<float> found = known_visibility(cache, coverage, light);
  const std::vector<float> traced = known_visibility(cache, *rays, light);
  double difference[2] = {};  // elsewhere, within 3 degrees of a face's edge
  double count[2] = {};
  size_t i = 0;
  const ViewReceivers view(cache);
  for (size_t t = 0; t < view.tile_count(); ++t) {
    view.visit_tile(t, [&](const ReceiverGroup& group) {
      for (int lane = 0; lane < group.receivers.count; ++lane) {
        if (!(group.receivers.weight[lane] > 0)) continue;
        const vec3 p =
            glm::abs(vec3(group.receivers.position[0][lane], group.receivers.position[1][lane],
                          group.receivers.position[2][lane]));
        const float most = max_component(p);
        const float second = p.x + p.y + p.z - most - std::min(p.x, std::min(p.y, p.z));
        const int seam = second > 0.95f * most ? 1 : 0;
        difference[seam] += double{found[i]} - traced[i];
        count[seam] += 1;
        ++i;
      }
    });
  }
  ASSERT_GT(count[1], 100);
  EXPECT_NEAR(difference[0] / count[0], 0, 0.02);
  EXPECT_NEAR(difference[1] / count[1], 0, 0.05);
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/parallel.h"
#include "core/scene/procedural/generators.h"
#include "core/scene/scene.h"
#include "core/shade/shaders.h"

namespace relume {
namespace {

const Curves& strands_of(const Prototype& prototype) {
  return std::get<Curves>(prototype.shapes.at(1));
}

HairBallParams small_params() {
  HairBallParams params;
  params.strands = 3000;
  params.strand_materials = {3, 5, 8};
  params.ball_material = 1;
  return params;
}

bool same_bytes(const Curves& a, const Curves& b) {
  return a.points.size() == b.points.size() && a.offsets == b.offsets &&
         a.materials == b.materials &&
         std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(vec4)) == 0;
}

TEST(HairBall, HasTheAskedStrandsAndSegments) {
  for (const int segments : {1, 2, 8, 33}) {
    HairBallParams params = small_params();
    params.segments = segments;
    const Prototype ball = make_hair_ball(params);
    EXPECT_EQ(ball.name, "hair-ball");
    const Curves& curves = strands_of(ball);
    ASSERT_EQ(curves.offsets.size(), 3001u);
    for (size_t i = 0; i + 1 < curves.offsets.size(); ++i) {
      ASSERT_EQ(curves.offsets[i + 1] - curves.offsets[i], static_cast<uint32_t>(segments) + 1);
    }
    EXPECT_EQ(curves.offsets.back(), curves.points.size());
  }
}

TEST(HairBall, StrandsHaveTheirLengthAndStayOutsideTheBall) {
  const HairBallParams params = small_params();
  const Prototype ball = make_hair_ball(params);
  const Curves& curves = strands_of(ball);
  for (size_t strand = 0; strand < params.strands; ++strand) {
    double length = 0;
    for (uint32_t i = curves.offsets[strand]; i < curves.offsets[strand + 1]; ++i) {
      const vec3 p(curves.points[i]);
      ASSERT_TRUE(is_finite(p)) << "strand " << strand;
      ASSERT_GE(glm::length(p), params.ball_radius * 0.9999f) << "strand " << strand;
      ASSERT_LE(glm::length(p), params.ball_radius + params.length_high * 1.001f);
      ASSERT_GE(curves.points[i].w, params.strand_radius * params.tip_scale * 0.9999f);
      ASSERT_LE(curves.points[i].w, params.strand_radius);
      if (i == curves.offsets[strand]) continue;
      const double step = glm::length(p - vec3(curves.points[i - 1]));
      ASSERT_GT(step, 0) << "strand " << strand;
      ASSERT_LE(curves.points[i].w, curves.points[i - 1].w) << "tapers";
      length += step;
    }
    ASSERT_GE(length, params.length_low * 0.999) << "strand " << strand;
    ASSERT_LE(length, params.length_high * 1.001) << "strand " << strand;
  }
}

TEST(HairBall, RootsCoverTheBallEvenly) {
  HairBallParams params = small_params();
  params.strands = 20000;
  const Curves curves = strands_of(make_hair_ball(params));
  dvec3 sum(0);
  std::array<int, 8> octants{};
  for (size_t strand = 0; strand < params.strands; ++strand) {
    const vec3 root(curves.points[curves.offsets[strand]]);
    EXPECT_NEAR(glm::length(root), params.ball_radius, 1e-5);
    sum += dvec3(root);
    ++octants[(root.x > 0) + 2 * (root.y > 0) + 4 * (root.z > 0)];
  }
  EXPECT_LT(glm::length(sum) / params.strands, 2e-3);
  for (const int count : octants) EXPECT_NEAR(count, 2500, 60);
}

TEST(HairBall, DrawsMaterialsEvenly) {
  const Curves curves = strands_of(make_hair_ball(small_params()));
  std::array<int, 10> counts{};
  for (const uint32_t material : curves.materials) ++counts.at(material);
  // Binomial with n = 3000, p = 1/3: five standard deviations are 129.
  for (const uint32_t material : {3, 5, 8}) EXPECT_NEAR(counts[material], 1000, 129);
  EXPECT_EQ(counts[3] + counts[5] + counts[8], 3000);
}

TEST(HairBall, SkinLiesUnderTheRoots) {
  const HairBallParams params = small_params();
  const Prototype ball = make_hair_ball(params);
  const Mesh& skin = std::get<Mesh>(ball.shapes.at(0));
  for (const vec3 p : skin.positions) {
    ASSERT_LT(glm::length(p), params.ball_radius);
    ASSERT_GT(glm::length(p), 0.99f * params.ball_radius);
  }
  for (const uint32_t material : skin.materials) ASSERT_EQ(material, 1u);
}

TEST(HairBall, DependsOnTheSeedButNotOnThreads) {
  HairBallParams params = small_params();
  set_thread_count(1);
  const Curves one = strands_of(make_hair_ball(params));
  set_thread_count(4);
  const Curves four = strands_of(make_hair_ball(params));
  set_thread_count(0);
  EXPECT_TRUE(same_bytes(one, four));
  params.seed = 2;
  EXPECT_FALSE(same_bytes(one, strands_of(make_hair_ball(params))));
}

TEST(HairBall, KeepsTheSceneInvariantsAtTheExtremes) {
  Scene scene;
  scene.shaders.assign(shader_table().begin(), shader_table().end());
  const auto shader_of = [&](std::string_view name) {
    for (size_t i = 0; i < scene.shaders.size(); ++i) {
      if (scene.shaders[i]->name == name) return static_cast<int>(i);
    }
    return -1;
  };
  Material hair;
  hair.shader = shader_of("kajiya-kay");
  Material skin;
  skin.shader = shader_of("lambert");
  scene.materials = {hair, skin};
  const auto add = [&](HairBallParams params) {
    params.strand_materials = {0};
    params.ball_material = 1;
    scene.instances.push_back({static_cast<uint32_t>(scene.prototypes.size()), {}});
    scene.instances.back().world_from_local = identity_transform();
    scene.prototypes.push_back(make_hair_ball(params));
  };
  HairBallParams params;
  add(params);  // the defaults: >= 60,000 strands
  params.strands = 1;
  params.curl = 1;
  add(params);
  params = {};
  params.strands = 500;
  params.ball_radius = 100;
  params.length_low = 1;
  params.length_high = 400;
  params.segments = 100;
  params.tip_scale = 1;
  params.curl = 0;
  add(params);
  EXPECT_NO_THROW(validate_scene(scene));
  EXPECT_GE(count_scene(scene).strands, 60000u + 501u);
}

}  // namespace
}  // namespace relume

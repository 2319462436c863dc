#include <gtest/gtest.h>

#include "core/base/random.h"
#include "shadow/receiver_tree.h"
#include "shadow/thin_geometry.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

// Receivers as the light's rasteriser takes them: spots, and the tree over them.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// Everything that the tree of a scene's receivers is built from.
struct Learned {
  Scene scene;
  Tracer tracer;
  RelightCache cache;
  ThinGeometry geometry;
  LearnedReceivers receivers;

  Learned(Scene from, int spp)
      : scene(std::move(from)),
        tracer(scene),
        cache(make_full_cache(scene, tracer, spp)),
        geometry(make_thin_geometry(scene, scene.height)),
        receivers(learn_receivers(ViewReceivers(cache), tracer, geometry)) {}
};

/// A floor with strands on it.
Scene make_field() {
  Scene scene = make_empty_scene(make_camera({0, 2, 5}, {0, 0.2f, 0}, 40), 32, 32);
  add_shape(scene, make_quad(vec3(0), {0, 0, 3}, {3, 0, 0}, add_material(scene, "lambert")));
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Random random(3, RandomStream::tests, 0);
  for (int i = 0; i < 40; ++i) {
    const float x = random.uniform(-1, 1);
    const float z = random.uniform(-1, 1);
    add_shape(scene, make_strand({x, 0, z}, {x, 0.6f, z + 0.2f}, 0.01f, 3, hair));
  }
  return scene;
}

TEST(ReceiverTree, BoundsHoldEveryReceiverAndTheNearestIsKnown) {
  const Learned learned(make_field(), 4);
  const LearnedReceivers& receivers = learned.receivers;
  const CoverageKernels kernels = coverage_kernels(InstructionSet::scalar);
  for (const Light& light : {make_point_light({1, 3, 2}), make_point_light({0.1f, 0.5f, 0.2f}),
                             make_directional_light({-1, -2, 0.5f})}) {
    const LightViews lights = make_light_views(light, receivers.center, receivers.scale);
    ReceiverTree tree;
    std::vector<ReceiverState> states;
    std::vector<KeyedIndex> scratch;
    build_receiver_tree(receivers, lights, PixelShare::all, kernels, tree, states, scratch);
    std::array<float, max_light_views> nearest{};
    nearest.fill(std::numeric_limits<float>::infinity());
    size_t covered = 0;
    for (size_t i = 0; i < receivers.count(); ++i) {
      if (states[i] != ReceiverState::covered) continue;
      ++covered;
      const float* at = receivers.spots[i].position;
      const vec3 p(at[0], at[1], at[2]);
      const size_t v = lights.view_of(p);
      const ViewPoint seen = view_point(lights.views[v], p);
      nearest[v] = std::min(nearest[v], seen.w);
      ASSERT_TRUE(tree.views[v].is_used);
      const ReceiverNode& root = tree.nodes[tree.views[v].root];
      EXPECT_GE(seen.x / seen.w, root.u_low);
      EXPECT_LE(seen.x / seen.w, root.u_high);
      EXPECT_GE(seen.y / seen.w, root.v_low);
      EXPECT_LE(seen.y / seen.w, root.v_high);
    }
    EXPECT_EQ(tree.items.size(), covered);
    EXPECT_GT(covered, receivers.count() / 4);
    for (size_t v = 0; v < max_light_views; ++v) {
      EXPECT_EQ(tree.views[v].is_used, nearest[v] < std::numeric_limits<float>::infinity());
      if (!tree.views[v].is_used) continue;
      EXPECT_EQ(tree.views[v].w_low, nearest[v]) << v;
    }
  }
}

TEST(ReceiverTree, LeavesHardlyOverlap) {
  // A cloud of strands.
  Scene scene = make_empty_scene(make_camera({0, 0, 6}, vec3(0), 22), 128, 128);
  const uint32_t hair = add_material(scene, "kajiya-kay");
  Random random(6, RandomStream::tests, 0);
  for (int i = 0; i < 1500; ++i) {
    const vec3 middle = random_direction(random);
    const vec3 half = 0.15f * random_direction(random);
    add_shape(scene, make_strand(middle - half, middle + half, 0.02f, 2, hair));
  }
  const Learned learned(std::move(scene), 1);
  const LearnedReceivers& receivers = learned.receivers;
  const CoverageKernels kernels = coverage_kernels(InstructionSet::scalar);
  for (const double distance : {1.25, 1.5, 3.0, 100.0}) {  // radii
    const dvec3 place = receivers.center + distance * receivers.scale * dvec3(0, 1, 0);
    const LightViews lights =
        make_light_views(make_point_light(vec3(place)), receivers.center, receivers.scale);
    ReceiverTree tree;
    std::vector<ReceiverState> states;
    std::vector<KeyedIndex> scratch;
    build_receiver_tree(receivers, lights, PixelShare::all, kernels, tree, states, scratch);
    ASSERT_GE(tree.leaves.size(), 8u);
    const auto area = [](const ReceiverNode& node) {
      return (node.u_high - node.u_low) * (node.v_high - node.v_low);
    };
    float leaves = 0;
    for (const ReceiverNode& node : tree.nodes) leaves += node.child_count == 0 ? area(node) : 0;
    EXPECT_LT(leaves, 1.2f * area(tree.nodes[tree.views[0].root])) << distance;
  }
}

/// Half a tube of 16 facets with smooth normals, along x, open away from the camera.
Mesh make_bent_leaf(float radius, uint32_t material) {
  constexpr uint32_t steps = 16;
  Mesh mesh;
  for (uint32_t i = 0; i <= steps; ++i) {
    const float angle = pi * static_cast<float>(i) / steps;
    const vec3 normal(0, std::cos(angle), std::sin(angle));
    for (const float x : {-1.0f, 1.0f}) {
      mesh.positions.push_back(vec3(x, 0, 0) + radius * normal);
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

TEST(LearnedReceivers, SamplesOfOneBentLeafAreFewSpots) {
  // So narrow that a spot turns by more than what counts as one plane.
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 32, 32);
  const float pixel = 2 * 5 * std::tan(radians_from_degrees(20)) / 32;
  add_shape(scene, make_bent_leaf(0.6f * pixel, add_material(scene, "leaf")));
  const Learned learned(std::move(scene), 64);
  const auto records = static_cast<double>(learned.cache.info().record_count);
  ASSERT_GT(records, 1000);
  EXPECT_LT(static_cast<double>(learned.receivers.count()), 0.27 * records);
}

TEST(LearnedReceivers, SharesOfEachReceiverAreOne) {
  const Learned learned(make_field(), 4);
  std::vector<double> share(ViewReceivers(learned.cache).count(), 0.0);
  for (const ReceiverLink& link : learned.receivers.links) {
    ASSERT_LT(link.spot, learned.receivers.count());
    share.at(link.receiver) += double{link.share};
  }
  size_t known = 0;
  for (const double sum : share) {
    if (sum == 0) continue;
    EXPECT_NEAR(sum, 1, 1e-6);
    ++known;
  }
  EXPECT_EQ(known, learned.cache.info().record_count);
}

}  // namespace
}  // namespace relume

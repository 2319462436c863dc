#include <gtest/gtest.h>

#include "core/base/random.h"
#include "shadow/depth_map.h"
#include "shadow/lookup_kernel.h"
#include "shadow/volume_grid.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

// The maps, grids and kernels that opacity and volume are built on.

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

Scene make_strands(int count, float radius) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
  add_material(scene, "kajiya-kay");
  for (int i = 0; i < count; ++i) {
    Random random(2, RandomStream::tests, static_cast<uint64_t>(i));
    const vec3 root = 0.6f * random_direction(random);
    const vec3 tip = root + 0.3f * random_direction(random);
    add_shape(scene, make_strand(root, tip, radius, 3, 0));
  }
  return scene;
}

TEST(LightPlanes, HoldEveryPointOfTheirBoxes) {
  std::vector<Bounds> boxes;
  for (uint64_t i = 0; i < 20; ++i) {
    Random random(1, RandomStream::tests, i);
    Bounds box;
    const vec3 p = random_direction(random);
    box.extend(p);
    box.extend(p + 0.2f * random_direction(random));
    boxes.push_back(box);
  }
  for (const Light& light :
       {make_point_light({3, 2, 1}), make_point_light({0.2f, 0.1f, 0}),
        make_directional_light({1, -2, 3}), make_point_light({0.9f, 0.1f, 0.4f}),
        make_point_light({1e9f, 1e9f, 0})}) {
    const auto planes = fit_light_planes(light, boxes, {}, 1u << 20);
    ASSERT_FALSE(planes.empty());
    uint64_t texels = 0;
    for (const LightPlane& plane : planes) texels += uint64_t{1} * plane.width * plane.height;
    EXPECT_LT(texels, 1.3 * (1u << 20));
    EXPECT_GT(texels, (1u << 20) / 4);
    for (uint64_t i = 0; i < 2000; ++i) {
      Random random(2, RandomStream::tests, i);
      const Bounds& box = boxes[i % boxes.size()];
      vec3 p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = box.low[axis] + (box.high[axis] - box.low[axis]) * random.uniform();
      }
      const int index = find_plane(planes, p);
      ASSERT_GE(index, 0);
      const LightPlane& plane = planes[index];
      const auto at = plane.project(plane.to_light(p));
      EXPECT_GE(at.u, 2);
      EXPECT_GE(at.v, 2);
      EXPECT_LE(at.u, plane.width - 2);
      EXPECT_LE(at.v, plane.height - 2);
      EXPECT_GT(at.nearness, 0);
    }
  }
}

TEST(LightPlanes, SeeNoMoreThanTheBoxes) {
  Bounds box;
  box.extend(vec3(-1, -0.1f, -0.1f));
  box.extend(vec3(1, 0.1f, 0.1f));
  EXPECT_EQ(fit_light_planes(make_point_light({0, 9, 0}), {&box, 1}, {}, 4096).size(), 1u);
  EXPECT_GE(fit_light_planes(make_point_light({0, 0, 0}), {&box, 1}, {}, 4096).size(), 2u);
  EXPECT_TRUE(fit_light_planes(make_point_light({0, 9, 0}), {}, {}, 4096).empty());
}

/// A plane that looks down -z at the square of side 2 around the origin.
LightPlane make_plane(int texels) {
  LightPlane plane;
  plane.perspective = false;
  plane.z = {0, 0, -1};
  plane.scale = 0.5f * static_cast<float>(texels);
  plane.offset_u = plane.offset_v = 0.5f * static_cast<float>(texels);
  plane.far = 10;
  plane.width = plane.height = texels;
  return plane;
}

int covered_texels(const DepthMap& map) {
  int count = 0;
  for (int i = 0; i < map.view().width * map.view().height; ++i) count += map.texels()[i] > 0;
  return count;
}

TEST(DepthMap, CoversAsManyTexelsAsTheAreaSeen) {
  // Strands from a tenth of a texel wide to several: on average no more and no less than theirs.
  constexpr int texels = 400;
  for (const float width_px : {0.1f, 0.4f, 1.0f, 2.9f, 6.0f}) {
    const float radius = width_px / texels;  // half of width * (2 / texels)
    double drawn = 0;
    double expected = 0;
    for (uint64_t i = 0; i < 300; ++i) {
      Random random(3, RandomStream::tests, i);
      const float angle = random.uniform(0, 2 * pi);
      const float x = random.uniform(-0.3f, 0.3f);
      const float y = random.uniform(-0.3f, 0.3f);
      const vec3 half = 0.25f * vec3(std::cos(angle), std::sin(angle), 0.1f);
      DepthMap map(make_plane(texels));
      map.draw({vec3(x, y, 0) - half, vec3(x, y, 0) + half, vec3(0), radius, radius});
      drawn += covered_texels(map);
      expected += 0.5 * texels * 0.5 * width_px;
    }
    EXPECT_NEAR(drawn / expected, 1, 0.05) << width_px;
  }
}

TEST(DepthMap, KeepsTheNearest) {
  DepthMap map(make_plane(64));
  const auto draw = [&map](float z) {
    map.draw({{-0.5f, -0.5f, z}, {0.5f, -0.5f, z}, {0, 0.5f, z}});
  };
  draw(1);
  const int covered = covered_texels(map);
  EXPECT_NEAR(covered, 0.5 * 32 * 32, 20);
  const float before = map.texels()[32 * 64 + 32];
  EXPECT_NEAR(before, 11, 1e-4) << "z = 1 is 11 before the far plane";
  draw(0);
  EXPECT_EQ(map.texels()[32 * 64 + 32], before);
  draw(2);
  EXPECT_NEAR(map.texels()[32 * 64 + 32], 12, 1e-4);
  EXPECT_EQ(covered_texels(map), covered);
}

TEST(DepthMap, StrandsInBandsAreStrandsOneByOne) {
  const Scene scene = make_strands(300, 0.003f);
  const SceneStrips strips(scene);
  const Bounds box = strips.bounds();
  for (const Light& light : {make_point_light({2, 3, 1}), make_point_light({0.1f, 0, 0}),
                             make_directional_light({1, 2, 3})}) {
    for (const LightPlane& plane : fit_light_planes(light, {&box, 1}, {}, 300'000)) {
      DepthMap one(plane);
      for (size_t i = 0; i < strips.instance_count(); ++i) {
        strips.visit(i, [&](const Strip& piece) { one.draw(piece); });
      }
      DepthMap bands(plane);
      bands.draw_strands(strips.strands());
      int different = 0;
      for (int i = 0; i < plane.width * plane.height; ++i) {
        different += one.texels()[i] != bands.texels()[i] ? 1 : 0;
      }
      EXPECT_LE(different, covered_texels(one) / 500) << "centres on an outline round either way";
      EXPECT_GT(covered_texels(one), 1000);
    }
  }
}

/// Area of all cells as seen along a unit vector, world units.
double area_seen(const VolumeGrid& grid, vec3 w) {
  double area = 0;
  for (size_t i = 0; i < grid.occupied.size(); ++i) {
    const auto& q = grid.moments[i];
    const double form = (q[0] * w.x * w.x + q[1] * w.y * w.y + q[2] * w.z * w.z +
                         2.0 * (q[3] * w.x * w.y + q[4] * w.x * w.z + q[5] * w.y * w.z)) /
                        127;
    area += grid.area[i] * std::sqrt(std::max(0.0, form));
  }
  return area * grid.cell * grid.cell;
}

TEST(VolumeGrid, KeepsTheAreaSeenFromEverywhere) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
  add_material(scene, "kajiya-kay");
  add_material(scene, "leaf");
  add_shape(scene, make_strand({-1, 0, 0}, {1, 0, 0}, 0.01f, 7, 0));
  add_shape(scene, make_quad({0, 0.5f, 0.5f}, {0.2f, 0, 0}, {0, 0.1f, 0}, 1));
  const SceneStrips strips(scene);
  EXPECT_EQ(strips.count(), 9u);
  const VolumeGrid grid = make_volume_grid(strips, {.max_cells = 200'000});
  const float h = grid.cell;
  const double strand = 0.04 * clumping(0.02f / h, 2.0f / 7 / h);
  const float diagonal = std::sqrt(0.2f);
  const double leaf = 0.08 * clumping(0.08f / diagonal / h, diagonal / h);
  EXPECT_NEAR(area_seen(grid, {1, 0, 0}), 0, 2e-3) << "along the strand, in the leaf's plane";
  EXPECT_NEAR(area_seen(grid, {0, 1, 0}), strand, 1e-3) << "the strand alone";
  EXPECT_NEAR(area_seen(grid, {0, 0, 1}), strand + leaf, 1e-3) << "both";
  const float s = std::sqrt(0.5f);
  EXPECT_NEAR(area_seen(grid, {s, 0, s}), s * (strand + leaf), 3e-3);
}

TEST(VolumeGrid, StaysBelowItsLimits) {
  const Scene scene = make_strands(400, 0.002f);
  const SceneStrips strips(scene);
  const VolumeGrid fine = make_volume_grid(strips, {.max_cells = 500'000});
  EXPECT_LE(fine.cell_count(), 500'000u);
  EXPECT_GT(fine.cell_count(), 250'000u);
  const VolumeGrid sparse = make_volume_grid(strips, {.max_cells = 500'000, .max_occupied = 4000});
  EXPECT_LE(sparse.occupied.size(), 4000u);
  EXPECT_GT(sparse.cell, fine.cell);
  EXPECT_TRUE(std::ranges::is_sorted(fine.occupied));
  EXPECT_NEAR(area_seen(fine, {0, 0, 1}), area_seen(sparse, {0, 0, 1}),
              0.05 * area_seen(fine, {0, 0, 1}));
}

TEST(VolumeGrid, ClumpingIsOneForWhatIsThin) {
  EXPECT_NEAR(clumping(1e-3f, 10), 1, 1e-3);
  EXPECT_EQ(clumping(0, 5), 1);
  EXPECT_GT(clumping(3, 3), 1.3f);
  EXPECT_LT(clumping(3, 3), clumping(6, 6));
}

class LookupKernel : public testing::TestWithParam<InstructionSet> {
 protected:
  void SetUp() override {
    if (!is_supported(GetParam())) GTEST_SKIP() << "not on this machine";
  }
  /// Sixteen receivers in the cube of side 2.
  LookupReceivers make_receivers(uint64_t seed) {
    Random random(seed, RandomStream::tests, 0);
    for (auto& axis : position_) {
      for (float& x : axis) x = random.uniform(-1, 1);
    }
    for (float& b : bias_) b = random.uniform(0, 0.01f);
    return {{position_[0], position_[1], position_[2]}, bias_};
  }

 private:
  float position_[3][lookup_lanes];
  float bias_[lookup_lanes];
};

TEST_P(LookupKernel, DepthMapsAgreeWithScalar) {
  const LookupKernels kernels = lookup_kernels(GetParam());
  const LookupKernels scalar = lookup_kernels(InstructionSet::scalar);
  std::vector<float> texels(128 * 96);
  Random random(5, RandomStream::tests, 0);
  for (float& texel : texels) texel = random.uniform(0, 1);
  for (uint64_t i = 0; i < 200; ++i) {
    DepthLookup map{texels.data(),
                    128,
                    96,
                    {0.1f, -0.2f, 3},
                    {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                    i % 2 == 0,
                    90.0f,
                    64,
                    48,
                    3.5f,
                    0.01f,
                    2};
    if (!map.perspective) map.scale = 40;
    const LookupReceivers receivers = make_receivers(i);
    float a[lookup_lanes];
    float b[lookup_lanes];
    std::fill(std::begin(a), std::end(a), 0.7f);
    std::fill(std::begin(b), std::end(b), 0.7f);
    kernels.look_up_depth(map, receivers, a);
    scalar.look_up_depth(map, receivers, b);
    // A texel's nearness may lie on the limit to the last bit.
    for (int lane = 0; lane < lookup_lanes; ++lane) EXPECT_NEAR(a[lane], b[lane], 1e-3) << i;
    kernels.sort_by_depth(map, receivers, a);
    scalar.sort_by_depth(map, receivers, b);
    for (int lane = 0; lane < lookup_lanes; ++lane) EXPECT_EQ(a[lane], b[lane]) << i;
  }
}

TEST_P(LookupKernel, MarchesAgreeWithScalar) {
  const LookupKernels kernels = lookup_kernels(GetParam());
  const LookupKernels scalar = lookup_kernels(InstructionSet::scalar);
  VolumeLookup volume{};
  std::vector<uint16_t> levels[VolumeLookup::max_levels];
  const int sizes[3] = {48, 32, 64};
  Random random(6, RandomStream::tests, 0);
  for (int l = 0; l < VolumeLookup::max_levels; ++l) {
    levels[l].resize((sizes[0] >> l) * (sizes[1] >> l) * (sizes[2] >> l) + 1);
    for (uint16_t& code : levels[l]) code = static_cast<uint16_t>(random.below(6000));
    volume.coverage[l] = levels[l].data();
  }
  for (int axis = 0; axis < 3; ++axis) {
    volume.size[axis] = sizes[axis];
    volume.origin[axis] = -0.9f;
  }
  volume.inverse_cell = 25;
  volume.steps = 4;
  for (uint64_t i = 0; i < 200; ++i) {
    const vec3 light = (i % 3 == 0 ? 0.5f : 4.0f) * random_direction(random);
    volume.parallel = i % 5 == 0;
    volume.gap = i % 4 == 0 ? 1.0f : 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      volume.light[axis] = volume.parallel ? glm::normalize(light)[axis] : light[axis];
    }
    const LookupReceivers receivers = make_receivers(i);
    float a[lookup_lanes];
    float b[lookup_lanes];
    kernels.march_volume(volume, receivers, a);
    scalar.march_volume(volume, receivers, b);
    for (int lane = 0; lane < lookup_lanes; ++lane) {
      EXPECT_NEAR(a[lane], b[lane], 1e-3) << i << " lane " << lane;
      EXPECT_GE(a[lane], 0);
      EXPECT_LE(a[lane], 1);
    }
  }
}

TEST_P(LookupKernel, MarchCountsEverySlabOnce) {
  // All cells stop one hundredth: along an axis through n cells 0.99^n passes, coarse levels or
  // not.
  const LookupKernels kernels = lookup_kernels(GetParam());
  VolumeLookup volume{};
  std::vector<uint16_t> levels[VolumeLookup::max_levels];
  for (int l = 0; l < VolumeLookup::max_levels; ++l) {
    const double open = std::pow(0.99, 1 << l);
    levels[l].assign((64 >> l) * (64 >> l) * (64 >> l) + 1,
                     static_cast<uint16_t>(std::lround(65535 * (1 - open))));
    volume.coverage[l] = levels[l].data();
  }
  for (int axis = 0; axis < 3; ++axis) {
    volume.size[axis] = 64;
    volume.origin[axis] = -1;
  }
  volume.inverse_cell = 32;
  volume.steps = 5;
  float position[3][lookup_lanes] = {};
  const float bias[lookup_lanes] = {};
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      for (int lane = 0; lane < lookup_lanes; ++lane) {
        for (int other = 0; other < 3; ++other) position[other][lane] = 0;
        position[axis][lane] = -sign * (1 - 0.11f * static_cast<float>(lane));
      }
      for (const float distance : {10.0f, 0.95f}) {
        for (int other = 0; other < 3; ++other)
          volume.light[other] = other == axis ? sign * distance : 0;
        float passed[lookup_lanes];
        kernels.march_volume(volume, {{position[0], position[1], position[2]}, bias}, passed);
        for (int lane = 0; lane < lookup_lanes; ++lane) {
          const double cells = 32 * (std::min(1.0f, distance) - sign * position[axis][lane]);
          const double expected = cells > 0 ? std::pow(0.99, cells) : 1;
          EXPECT_NEAR(passed[lane], expected, 0.01) << axis << " " << sign << " lane " << lane;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, LookupKernel,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512));

}  // namespace
}  // namespace relume

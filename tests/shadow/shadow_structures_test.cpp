#include <gtest/gtest.h>

#include "core/base/random.h"
#include "shadow/depth_map.h"
#include "shadow/light_grid.h"
#include "shadow/lookup_kernel.h"
#include "shadow/solid_shadow.h"
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

TEST(DepthMap, TellsTheMemoryOfItsBandsToo) {
  const Scene scene = make_strands(300, 0.003f);
  const SceneStrips scene_strips(scene);
  const StrandSet strands = scene_strips.strands();
  DepthMap map(make_plane(400));
  const uint64_t texels = uint64_t{400} * 400 * sizeof(float);
  EXPECT_EQ(map.memory_bytes(), texels);
  map.draw_strands(strands);
  EXPECT_GE(map.memory_bytes(), texels + strands.memory_bytes())
      << "each point is projected, each segment in a band or more";
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

TEST(VolumeGrid, StaysBelowItsLimitsInManyParts) {
  // More cells than are filled in one go.
  const Scene scene = make_strands(400, 0.002f);
  const VolumeParams params{
      .max_cells = 2'500'000, .max_strand_cells = 2'500'000, .max_occupied = 10'000};
  const VolumeGrid grid = make_volume_grid(SceneStrips(scene), params);
  EXPECT_LE(grid.occupied.size(), params.max_occupied);
  EXPECT_GT(grid.occupied.size(), params.max_occupied / 2);
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

TEST_P(LookupKernel, SolidsThatAReceiverLiesOnAreNotBeforeIt) {
  // A plane seen at a slant: receivers on it are lit, those a texel and more behind it dark.
  const LookupKernels kernels = lookup_kernels(GetParam());
  for (const bool perspective : {false, true}) {
    std::vector<float> texels(64 * 64);
    DepthLookup map{texels.data(), 64, 64, {}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                    perspective,   30, 32, 32, 10,
                    0.01f,         2};
    const vec3 n = glm::normalize(vec3(0.6f, 0.2f, -1));
    const vec3 anchor(0, 0, 3);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        const vec3 at((static_cast<float>(x) - 31.5f) / 30, (static_cast<float>(y) - 31.5f) / 30,
                      1);
        const float along = glm::dot(n, at) / glm::dot(n, anchor);
        const float depth = (glm::dot(n, anchor) - n.x * at.x - n.y * at.y) / n.z;
        texels[64 * y + x] = perspective ? along : map.far - depth;
      }
    }
    float position[3][lookup_lanes];
    float normal[3][lookup_lanes];
    const float bias[lookup_lanes] = {};
    for (const float behind : {0.0f, 1.0f}) {
      for (int lane = 0; lane < lookup_lanes; ++lane) {
        const float x = 0.05f * static_cast<float>(lane) - 0.4f;
        const vec3 on_plane(x, 0.1f, anchor.z - (n.x * x + n.y * 0.1f) / n.z);
        for (int axis = 0; axis < 3; ++axis) {
          position[axis][lane] = (on_plane - behind * n)[axis];
          normal[axis][lane] = n[axis];
        }
      }
      float state[lookup_lanes];
      std::fill(std::begin(state), std::end(state), 2.0f);
      kernels.sort_by_depth(
          map, {{position[0], position[1], position[2]}, bias, {normal[0], normal[1], normal[2]}},
          state);
      for (const float sorted : state) EXPECT_EQ(sorted, behind) << perspective;
    }
  }
}

TEST_P(LookupKernel, SweepsAgreeWithScalar) {
  const LookupKernels kernels = lookup_kernels(GetParam());
  const LookupKernels scalar = lookup_kernels(InstructionSet::scalar);
  for (const int step : {1, 40}) {
    std::vector<float> cells(40 * 40);
    Random random(6, RandomStream::tests, 0);
    for (float& cell : cells) cell = random.uniform(0, 1);
    // Rows of 40 cells, from the first row or column to the sixth.
    const int other = 41 - step;
    for (int begin = 0; begin < 20; ++begin) {
      const SweepRow row{5 * other, step, begin, 39 - begin / 2, {3 * other, 4 * other}, 0.3f, 1.1f,
                         0.93f,     2,    35};
      std::vector<float> a = cells;
      std::vector<float> b = cells;
      kernels.sweep_row(a.data(), row);
      scalar.sweep_row(b.data(), row);
      for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-6f) << i;
      EXPECT_NE(b, cells);
    }
  }
}

TEST_P(LookupKernel, LightGridsAgreeWithScalar) {
  const LookupKernels kernels = lookup_kernels(GetParam());
  const LookupKernels scalar = lookup_kernels(InstructionSet::scalar);
  std::vector<float> cells(32 * 48 * 16);
  Random random(7, RandomStream::tests, 0);
  for (float& cell : cells) cell = random.uniform(0, 1);
  for (uint64_t i = 0; i < 200; ++i) {
    const vec3 light = (i % 3 == 0 ? 10.0f : 90.0f) * random_direction(random);
    LightGridLookup grid{cells.data(), {32, 48, 16}, {-0.8f, -0.9f, -0.5f}, 25, i % 5 == 0,
                         {},           0.5f};
    for (int axis = 0; axis < 3; ++axis) {
      grid.light[axis] = grid.parallel ? glm::normalize(light)[axis] : light[axis];
    }
    const LookupReceivers receivers = make_receivers(i);
    float a[lookup_lanes];
    float b[lookup_lanes];
    kernels.look_up_light(grid, receivers, a);
    scalar.look_up_light(grid, receivers, b);
    for (int lane = 0; lane < lookup_lanes; ++lane) {
      EXPECT_NEAR(a[lane], b[lane], 1e-3) << i << " lane " << lane;
      EXPECT_GE(a[lane], 0);
      EXPECT_LE(a[lane], 1);
    }
  }
}

TEST_P(LookupKernel, LightThatMissesTheGridComesWhole) {
  // A grid that lets nothing pass, and rays that cross its slabs one after the other.
  const std::vector<float> cells(32 * 32 * 32, 0.0f);
  LightGridLookup grid{cells.data(), {32, 32, 32}, {0, 0, 0}, 1, false, {30, 100, 16}, 0.5f};
  float position[3][lookup_lanes];
  const float bias[lookup_lanes] = {};
  for (int lane = 0; lane < lookup_lanes; ++lane) {
    const bool is_before = lane % 2 == 0;  // beside the grid, or right below it
    position[0][lane] = is_before ? -10.0f - static_cast<float>(lane) : 16.0f;
    position[1][lane] = is_before ? 20.0f : -5.0f - static_cast<float>(lane);
    position[2][lane] = 16;
  }
  for (const bool is_parallel : {false, true}) {
    grid.parallel = is_parallel;
    const vec3 towards = is_parallel ? glm::normalize(vec3(1, 2, 0)) : vec3(30, 100, 16);
    for (int axis = 0; axis < 3; ++axis) grid.light[axis] = towards[axis];
    float passed[lookup_lanes];
    lookup_kernels(GetParam())
        .look_up_light(grid, {{position[0], position[1], position[2]}, bias}, passed);
    for (int lane = 0; lane < lookup_lanes; ++lane) {
      EXPECT_EQ(passed[lane], lane % 2 == 0 ? 1.0f : 0.0f) << lane << " " << is_parallel;
    }
  }
}

/// Cells that all hold the same area, the same seen from everywhere.
VolumeGrid make_even_grid(float area) {
  VolumeGrid grid;
  grid.size = {32, 32, 32};
  for (uint32_t i = 0; i < grid.cell_count(); ++i) grid.occupied.push_back(i);
  grid.area.assign(grid.cell_count(), area);
  grid.moments.assign(grid.cell_count(), {127, 127, 127, 0, 0, 0});
  return grid;
}

TEST(LightGrid, LightPassesEverySlabOnce) {
  // In an even grid n slabs let (1 - c)^n pass, with c a cell's coverage along the ray; lights on a
  // cell's centre, on its corner and elsewhere, so that cells lie as far off along two axes.
  const VolumeGrid grid = make_even_grid(0.04f);
  for (const vec3 light : {vec3(10.5f), vec3(12), vec3(3.2f, 20.1f, 15.7f), vec3(-20, 14, 9)}) {
    LightGrid lit(grid);
    lit.sweep(make_point_light(light));
    const LightGridLookup lookup = lit.lookup(0);
    for (uint64_t i = 0; i < 500; ++i) {
      Random random(8, RandomStream::tests, i);
      int cell[3];
      for (int& place : cell) place = 2 + static_cast<int>(random.below(28));
      const vec3 way = vec3(cell[0], cell[1], cell[2]) + 0.5f - light;
      const float across = max_abs_component(way);
      if (across < 3) continue;
      // What enters the grid from outside meets no cells before it, and the outer ones let all
      // light pass to the next.
      const vec3 size = glm::abs(way);
      const int axis = size.x == across ? 0 : size.y == across ? 1 : 2;
      const bool outside = light.x < 0;
      if (outside && axis != 0) continue;
      const float slabs = outside ? static_cast<float>(cell[0]) + 1 : across + 0.5f;
      const float seen = 0.04f * glm::length(way) / across;
      const float open = (1 - 0.5f * seen) * (1 - 0.5f * seen);
      const float left = lookup.cells[(cell[2] * 32 + cell[1]) * 32 + cell[0]];
      // Between the axes light comes from a little off its way, where cells stop less.
      EXPECT_NEAR(left, std::pow(open, slabs), 0.1f * left + 0.01f)
          << i << " " << cell[0] << " " << cell[1] << " " << cell[2];
    }
  }
}

TEST(LightGrid, ParallelLightRunsDownEveryAxis) {
  const VolumeGrid grid = make_even_grid(0.04f);
  LightGrid lit(grid);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {1.0f, -1.0f}) {
      vec3 direction(0.01f);
      direction[axis] = sign;
      lit.sweep(make_directional_light(direction));
      const LightGridLookup lookup = lit.lookup(0);
      for (int i = 0; i < 32; ++i) {
        int cell[3] = {16, 16, 16};
        cell[axis] = sign > 0 ? i : 31 - i;
        const float left = lookup.cells[(cell[2] * 32 + cell[1]) * 32 + cell[0]];
        EXPECT_NEAR(left, std::pow(0.98f * 0.98f, static_cast<float>(i + 1)), 1e-3f) << axis;
      }
    }
  }
}

TEST(SolidShadow, OfALightDoesNotDependOnTheOneBefore) {
  Scene scene = make_empty_scene(make_camera({0, 0, 5}, vec3(0), 40), 8, 8);
  add_shape(scene, make_sphere({0, 0, 0}, 0.5f, 24, add_material(scene, "lambert")));
  const SceneStrips strips(scene);
  // Receivers are asked for in a small box; points lie outside of it too.
  Bounds box;
  box.extend(vec3(-0.15f, -1.05f, -0.15f));
  box.extend(vec3(0.15f, -0.75f, 0.15f));
  std::vector<vec4> points;
  for (uint64_t i = 0; i < 2000; ++i) {
    Random random(12, RandomStream::tests, i);
    const float x = random.uniform(-4, 4);
    const float y = random.uniform(-1.5f, -0.6f);
    points.emplace_back(x, y, random.uniform(-4, 4), 0.0f);
  }
  const std::vector<Light> lights = {make_point_light({0, 3, 0}), make_point_light({1.5f, 2, 0}),
                                     make_directional_light({0.2f, -1, 0.1f}),
                                     make_point_light({0, -1, 0}), make_point_light({-1, 2, 1})};
  SolidShadow moved(strips, {box});
  for (const Light& light : lights) {
    SolidShadow fresh(strips, {box});
    fresh.prepare(light);
    moved.prepare(light);
    std::vector<uint8_t> expected;
    std::vector<uint8_t> hidden;
    fresh.mark_hidden(points, expected);
    moved.mark_hidden(points, hidden);
    EXPECT_EQ(hidden, expected) << light.position.x << " " << light.position.y;
    const bool is_inside = light.position.y < 0;
    EXPECT_EQ(std::ranges::count(expected, 1) == 0, is_inside);
    EXPECT_EQ(moved.memory_bytes(), fresh.memory_bytes());
  }
}

INSTANTIATE_TEST_SUITE_P(Sets, LookupKernel,
                         testing::Values(InstructionSet::scalar, InstructionSet::sse42,
                                         InstructionSet::avx2, InstructionSet::avx512));

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/samples/cache_writer.h"
#include "core/samples/pack.h"
#include "core/samples/sample_scene.h"
#include "core/shade/shaders.h"
#include "shadow/coverage.h"
#include "shadow/members.h"
#include "shadow/shadow.h"
#include "tests/support/expect_error.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// Strands above a floor.
Scene make_strand_scene() {
  Scene scene = make_empty_scene(make_camera({0, 1, 4}, {0, 0.4f, 0}, 40), 32, 32);
  const uint32_t floor = add_material(scene, "lambert");
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_quad(vec3(0), {0, 0, 3}, {3, 0, 0}, floor));
  for (int i = 0; i < 60; ++i) {
    const float x = -1.2f + 0.04f * static_cast<float>(i);
    add_shape(scene, make_strand({x, 0, 0}, {x + 0.1f, 0.9f, 0.1f}, 0.006f, 4, hair));
  }
  return scene;
}

/// One record a pixel and type, at its first sample, that knows `stored` of its samples.
RelightCache make_merged_cache(const Scene& scene, const Tracer& tracer, int spp, int stored) {
  const ViewSampler view = make_view_sampler(scene, tracer, scene.width, scene.height, spp, 1);
  CacheWriter writer;
  for (int i = 0; i < tile_count(view); ++i) {
    const SampleTile samples = sample_tile(view, i);
    SampleTile records = samples;
    records.has_footprints = true;
    records.has_members = stored > 0;
    for (size_t t = 0; t < samples.types.size(); ++t) {
      const TypedRows& rows = samples.types[t];
      const SampleType& type = view.types.types[t];
      const int normal = field_offset(type, FieldSource::normal);
      TypedRows& out = records.types[t];
      out = TypedRows();
      out.first.push_back(0);
      for (int pixel = 0; pixel < samples.pixel_count(); ++pixel) {
        const uint32_t begin = rows.first[pixel];
        const uint32_t end = rows.first[pixel + 1];
        if (end > begin) {
          const float* anchor = &rows.values[size_t{begin} * type.width];
          out.values.insert(out.values.end(), anchor, anchor + type.width);
          out.weights.push_back(static_cast<float>(end - begin) / static_cast<float>(spp));
          Footprint& footprint = out.footprints.emplace_back();
          footprint.samples = static_cast<int>(end - begin);
          footprint.stored_members = end - begin < 2 ? 0 : std::min<int>(stored, end - begin);
          // All of the spread along one axis bounds the offsets whatever they are.
          float largest = 0;
          for (int m = 0; m < footprint.samples; ++m) {
            const float* v = anchor + static_cast<size_t>(m) * type.width;
            Member member;
            member.offset = vec3(v[0], v[1], v[2]) - vec3(anchor[0], anchor[1], anchor[2]);
            if (normal >= 0) member.normal = vec3(v[normal], v[normal + 1], v[normal + 2]);
            largest = std::max(largest, max_abs_component(member.offset));
            if (m < footprint.stored_members) out.members.push_back(member);
          }
          footprint.covariance[0] = largest * largest;
        }
        out.first.push_back(static_cast<uint32_t>(out.rows()));
      }
    }
    writer.add(pack_tile(records, view.types.types));
  }
  writer.finish(make_cache_info(scene, view.types, spp, 1));
  return RelightCache::from_bytes(writer.take_bytes(), shader_table(), "merged");
}

/// Per pixel: sum over records of weight times visibility.
std::vector<double> pixel_visibility(const RelightCache& cache, VisibilitySource& source,
                                     const Light& light) {
  const CacheInfo& info = cache.info();
  source.prepare(light);
  std::vector<double> sums(static_cast<size_t>(info.width) * info.height);
  for (const PackedTile& tile : cache.tiles()) {
    size_t receiver = tile.first_slot * block_lanes;
    for (int b = 0; b < tile.block_count; ++b) {
      const PackedBlock block = cache.block(tile, b);
      const float* slot = block.floats();
      for (size_t t = 0; t < info.types.size(); ++t) {
        for (int s = 0; s < block.slots[t]; ++s) {
          Receivers receivers;
          receivers.count = block_lanes;
          receivers.first = receiver;
          float visibility[block_lanes];
          source.visibility(receivers, visibility);
          for (int lane = 0; lane < block.lanes; ++lane) {
            const int x = tile.x0 + block.pixels[lane] % tile_size;
            const int y = tile.y0 + block.pixels[lane] / tile_size;
            sums[static_cast<size_t>(y) * info.width + x] += slot[lane] * visibility[lane];
          }
          slot += (1 + info.types[t].width) * block_lanes;
          receiver += block_lanes;
        }
      }
    }
  }
  return sums;
}

double mean_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / static_cast<double>(a.size());
}

TEST(MemberVisibility, FromAllMembersIsThatOfAllSamples) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const Light light = make_point_light({2, 3, 2});
  const RelightCache all = make_full_cache(scene, tracer, 16);
  MemberVisibility exact(tracer, all, max_members);
  const std::vector<double> expected = pixel_visibility(all, exact, light);
  const RelightCache merged = make_merged_cache(scene, tracer, 16, max_members);
  MemberVisibility members(tracer, merged, max_members);
  // Rounding of positions lets single rays pass on the other side of a strand.
  EXPECT_LT(mean_difference(pixel_visibility(merged, members, light), expected), 5e-4);
  double last = mean_difference(pixel_visibility(merged, members, light), expected);
  for (const int rays : {4, 1}) {
    MemberVisibility fewer(tracer, merged, rays);
    const double error = mean_difference(pixel_visibility(merged, fewer, light), expected);
    EXPECT_GT(error, last) << rays << " rays";
    last = error;
  }
}

TEST(MemberVisibility, OfSamplesIsRay) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache all = make_full_cache(scene, tracer, 4);
  const std::vector<Light> lights = {make_point_light({2, 3, 2})};
  const auto ray = make_shadow(ShadowMethod::ray, tracer, all);
  const auto members = make_shadow(ShadowMethod::members, tracer, all);
  EXPECT_EQ(render_frame(all, lights, ray.get()).pixels,
            render_frame(all, lights, members.get()).pixels);
}

TEST(MemberVisibility, DoesNotDependOnTheThreads) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache merged = make_merged_cache(scene, tracer, 9, 5);
  const std::vector<Light> lights = {make_point_light({2, 3, 2})};
  std::vector<float> first;
  for (const int threads : {1, 2, 3, 8}) {
    set_thread_count(threads);
    MemberVisibility members(tracer, merged, 3);
    const Image frame = render_frame(merged, lights, &members);
    if (first.empty()) first = frame.pixels;
    EXPECT_EQ(frame.pixels, first) << threads << " threads";
  }
  set_thread_count(0);
}

TEST(Coverage, WithoutMembersAWideFootprintIsOneSample) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const Light light = make_point_light({2, 3, 2});
  const RelightCache all = make_merged_cache(scene, tracer, 16, max_members);
  const RelightCache none = make_merged_cache(scene, tracer, 16, 0);
  const RelightCache samples = make_full_cache(scene, tracer, 16);
  MemberVisibility exact(tracer, samples, 1);
  const std::vector<double> expected = pixel_visibility(samples, exact, light);
  CoverageVisibility of_all(tracer, all);
  CoverageVisibility of_none(tracer, none);
  MemberVisibility ray(tracer, none, 1);
  const double error = mean_difference(pixel_visibility(none, of_none, light), expected);
  EXPECT_GT(error, mean_difference(pixel_visibility(all, of_all, light), expected));
  EXPECT_LT(error, mean_difference(pixel_visibility(none, ray, light), expected));
  // A footprint over all of a pixel's strands would reach far more than its samples do.
  EXPECT_LT(of_none.stats().tests, of_all.stats().tests);
}

TEST(MemberVisibility, NeedsMembers) {
  const Scene scene = make_strand_scene();
  const Tracer tracer(scene);
  const RelightCache merged = make_merged_cache(scene, tracer, 4, 0);
  EXPECT_ERROR(make_shadow(ShadowMethod::members, tracer, merged), ErrorKind::input,
               "keeps no members");
  EXPECT_NE(make_shadow(ShadowMethod::members, tracer, merged, {.member_rays = 1}), nullptr);
}

}  // namespace
}  // namespace relume

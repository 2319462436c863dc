#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/relight/receivers.h"
#include "core/samples/cache_writer.h"
#include "core/shade/shaders.h"
#include "tests/support/records.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: record builders

float trace_of(const Footprint& footprint) {
  return footprint.covariance[0] + footprint.covariance[3] + footprint.covariance[5];
}

/// The footprint of a few random points within `extent` of the anchor, flat along `flat` axes.
Footprint make_random_footprint(Random& random, float extent, int flat) {
  vec3 points[6];
  vec3 mean(0);
  for (vec3& p : points) {
    p = extent * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    for (size_t axis = 0; axis < static_cast<size_t>(flat); ++axis) p[axis] = 0.5f * extent;
    mean += p / 6.0f;
  }
  Footprint footprint;
  footprint.offset = mean;
  footprint.samples = 6;
  for (const vec3 p : points) {
    const vec3 d = p - mean;
    const float squares[6] = {d.x * d.x, d.x * d.y, d.x * d.z, d.y * d.y, d.y * d.z, d.z * d.z};
    for (size_t i = 0; i < 6; ++i) footprint.covariance[i] += squares[i] / 6;
  }
  return footprint;
}

TEST(Footprint, SurvivesPackingAtEveryScale) {
  for (const float extent : {1e-8f, 1e-3f, 1.0f, 1e6f}) {
    for (int flat = 0; flat <= 3; ++flat) {
      Random random(1, RandomStream::tests, static_cast<uint64_t>(flat));
      for (int i = 0; i < 50; ++i) {
        const Footprint footprint = make_random_footprint(random, extent, flat);
        const Footprint stored = decode_footprint(encode_footprint(footprint));
        EXPECT_EQ(stored.samples, 6);
        for (size_t axis = 0; axis < 3; ++axis) {
          EXPECT_NEAR(stored.offset[axis], footprint.offset[axis], 0x1p-14f * extent);
        }
        for (size_t e = 0; e < 6; ++e) {
          EXPECT_NEAR(stored.covariance[e], footprint.covariance[e], 0x1p-11f * extent * extent);
        }
      }
    }
  }
}

TEST(Footprint, OfOneSampleHasNoExtent) {
  const Footprint stored = decode_footprint(encode_footprint(Footprint()));
  EXPECT_EQ(stored.offset, vec3(0));
  EXPECT_EQ(trace_of(stored), 0);
  EXPECT_EQ(stored.samples, 1);
  EXPECT_EQ(member_scale(stored), 0);
}

TEST(Footprint, AnyBitsAreFiniteAndPositiveSemidefinite) {
  Random random(2, RandomStream::tests, 0);
  for (int i = 0; i < 20000; ++i) {
    FootprintWords words;
    for (uint32_t& word : words) word = random.bits();
    const Footprint footprint = decode_footprint(words);
    ASSERT_TRUE(is_finite(footprint.offset));
    const std::array<float, 6>& c = footprint.covariance;
    for (const float x : c) ASSERT_TRUE(is_finite(x));
    ASSERT_GE(footprint.samples, 1);
    ASSERT_TRUE(is_finite(member_scale(footprint)));
    const dvec3 d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double variance = c[0] * d.x * d.x + c[3] * d.y * d.y + c[5] * d.z * d.z +
                            2 * (c[1] * d.x * d.y + c[2] * d.x * d.z + c[4] * d.y * d.z);
    ASSERT_GE(variance, -1e-6 * double{trace_of(footprint)} - 1e-37);
  }
}

TEST(Footprint, MembersAreKeptToTheirScale) {
  Random random(3, RandomStream::tests, 0);
  for (int i = 0; i < 1000; ++i) {
    Member member;
    member.offset = vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    member.normal = random_direction(random);
    const Member read = decode_member(encode_member(member, 1), 1, true);
    EXPECT_LT(glm::distance(read.offset, member.offset), 0x1p-15f);
    EXPECT_GT(glm::dot(read.normal, member.normal), 0.9998f);
    EXPECT_EQ(decode_member(encode_member(member, 1), 1, false).normal, vec3(0));
  }
}

/// Gives each row a footprint that tells which row it is, and as many members.
void fill_footprints(SampleTile& tile) {
  tile.has_footprints = true;
  tile.has_members = true;
  for (TypedRows& rows : tile.types) {
    for (size_t row = 0; row < rows.rows(); ++row) {
      Footprint& footprint = rows.footprints.emplace_back();
      footprint.samples = 1 + static_cast<int>(row % 7);
      footprint.offset = vec3(0.25f, static_cast<float>(row), 0);
      footprint.covariance[0] = 1;
      footprint.stored_members = static_cast<int>(row % 3);
      for (int i = 0; i < footprint.stored_members; ++i) {
        rows.members.push_back({vec3(static_cast<float>(row), 0, 0), vec3(0, 0, 1)});
      }
    }
  }
}

TEST(ViewReceivers, ComeInTheCachesOrderWithTheirFootprints) {
  const std::vector<SampleType> types = all_sample_types();
  for (const CacheFormat format : {CacheFormat::exact, CacheFormat::compact}) {
    CacheWriter writer;
    std::vector<SampleTile> tiles = make_random_tiles(types, 40, 20, 3);
    for (SampleTile& tile : tiles) {
      fill_footprints(tile);
      writer.add(pack_tile(tile, types, {format, make_tile_info(tile, types, {0, 0, 5}).camera}));
    }
    CacheInfo info = make_tile_info(tiles[0], types, {0, 0, 5});
    info.width = 40;
    info.height = 20;
    writer.finish(info);
    const RelightCache cache =
        RelightCache::from_bytes(writer.take_bytes(), shader_table(), "records");
    EXPECT_TRUE(cache.info().has_footprints);
    EXPECT_TRUE(cache.info().has_members);
    const ViewReceivers view(cache);
    size_t next = 0;
    uint64_t records = 0;
    for (size_t t = 0; t < view.tile_count(); ++t) {
      EXPECT_EQ(view.tile_first(t), next);
      view.visit_tile(t, [&](const ReceiverGroup& group) {
        EXPECT_EQ(group.receivers.first, next);
        next += group.receivers.count;
        size_t member = 0;
        for (int lane = 0; lane < group.receivers.count; ++lane) {
          const Footprint& footprint = group.footprints[lane];
          const bool present = group.receivers.weight[lane] > 0;
          records += present ? 1 : 0;
          const float row = footprint.offset.y;
          EXPECT_EQ(footprint.offset.x > 0, present);
          if (present) {
            EXPECT_EQ(footprint.samples, 1 + std::lround(row) % 7);
          }
          EXPECT_EQ(footprint.stored_members, present ? std::lround(row) % 3 : 0);
          for (int i = 0; i < footprint.stored_members; ++i) {
            EXPECT_NEAR(group.members[member++].offset.x, row, 1e-3f * (1 + row));
          }
        }
        EXPECT_EQ(member, group.members.size());
      });
    }
    EXPECT_EQ(next, view.count());
    EXPECT_EQ(records, cache.info().record_count);
  }
}

TEST(ViewReceivers, OfSamplesHaveNoExtent) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 16, 16, 2, 1);
  const RelightCache cache = make_tile_cache(tile, types, {0, 0, 5});
  const ViewReceivers view(cache);
  EXPECT_FALSE(view.has_footprints());
  view.visit_tile(0, [](const ReceiverGroup& group) {
    EXPECT_TRUE(group.members.empty());
    for (const Footprint& footprint : group.footprints) {
      EXPECT_EQ(footprint.samples, 1);
      EXPECT_EQ(trace_of(footprint), 0);
    }
  });
}

}  // namespace
}  // namespace relume

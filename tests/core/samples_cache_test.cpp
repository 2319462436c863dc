#include <gtest/gtest.h>

#include <cstring>

#include "core/base/parallel.h"
#include "core/samples/cache_writer.h"
#include "core/samples/relight_cache.h"
#include "core/shade/shaders.h"
#include "tests/support/expect_error.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"
#include "tests/support/temporary_folder.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and record builders

std::string text_of(const CacheBytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size() * sizeof(CacheChunk)};
}

CacheInfo full_info(const SampleTile& tile, const std::vector<SampleType>& types) {
  CacheInfo info = make_tile_info(tile, types, {0, 0, 5});
  info.method = "kmeans";
  info.records = 8;
  info.seed = 77;
  info.sample_count = 1234;
  info.scene_file = "scenes/x.json";
  info.scene_text = std::string("{ \"a\": 1 }\0 // binary", 21);
  info.exposure = -1.5f;
  info.average_records = 2.5f;
  info.target_error = 0.0125f;
  info.lights = {make_point_light({1, 2, 3}, 4),
                 make_spot_light({0, 1, 0}, {0, -1, 0}, 10, 30, false),
                 make_directional_light({1, 0, 0})};
  info.lights[1].name = "spot";
  info.lights[1].mute = true;
  info.lights[2].casts_shadow = false;
  info.representative_high.position = {9, 8, 7};
  return info;
}

CacheBytes write_memory(const SampleTile& tile, const CacheInfo& info) {
  CacheWriter writer;
  writer.add(pack_tile(tile, info.types));
  writer.finish(info);
  return writer.take_bytes();
}

class Cache : public testing::Test {
 protected:
  std::vector<SampleType> types_ = all_sample_types();
  SampleTile tile_ = make_random_tile(types_, 16, 13, 3, 1);
  CacheInfo info_ = full_info(tile_, types_);
  TemporaryFolder folder_;
};

TEST_F(Cache, FileAndMemoryHoldTheSameBytes) {
  const auto path = folder_.file("a.relume");
  CacheWriter writer(path);
  writer.add(pack_tile(tile_, types_));
  EXPECT_FALSE(std::filesystem::exists(path));
  writer.finish(info_);
  const std::string file = read_all(path);
  std::string memory = text_of(write_memory(tile_, info_));
  ASSERT_LE(file.size(), memory.size());
  ASSERT_LT(memory.size() - file.size(), sizeof(CacheChunk));
  memory.resize(file.size());
  EXPECT_EQ(file, memory);
  const RelightCache cache = RelightCache::open(path, shader_table());
  EXPECT_EQ(cache.size_bytes(), file.size());
}

TEST_F(Cache, InfoSurvivesTheRoundTrip) {
  info_.types[1].merges[3] = Merge::representative;
  info_.types[1].name = "phong#2";
  const RelightCache cache =
      RelightCache::from_bytes(write_memory(tile_, info_), shader_table(), "memory");
  const CacheInfo& read = cache.info();
  EXPECT_EQ(read.width, info_.width);
  EXPECT_EQ(read.height, info_.height);
  EXPECT_EQ(read.camera.eye, info_.camera.eye);
  EXPECT_EQ(read.camera.fov_y_deg, info_.camera.fov_y_deg);
  EXPECT_EQ(read.bounds.low, info_.bounds.low);
  EXPECT_EQ(read.bounds.high, info_.bounds.high);
  EXPECT_EQ(read.method, "kmeans");
  EXPECT_EQ(read.records, 8);
  EXPECT_EQ(read.spp, 25);
  EXPECT_EQ(read.seed, 77u);
  EXPECT_EQ(read.sample_count, 1234u);
  EXPECT_EQ(read.record_count, tile_.row_count());
  EXPECT_EQ(read.scene_file, info_.scene_file);
  EXPECT_EQ(read.scene_text, info_.scene_text);
  EXPECT_EQ(read.exposure, -1.5f);
  EXPECT_EQ(read.average_records, 2.5f);
  EXPECT_EQ(read.target_error, 0.0125f);
  EXPECT_FALSE(read.has_predicted_error);
  EXPECT_EQ(read.representative_high.position, vec3(9, 8, 7));
  ASSERT_EQ(read.lights.size(), 3u);
  EXPECT_EQ(read.lights[1].name, "spot");
  EXPECT_EQ(read.lights[1].type, LightType::spot);
  EXPECT_TRUE(read.lights[1].mute);
  EXPECT_FALSE(read.lights[1].falloff);
  EXPECT_FALSE(read.lights[2].casts_shadow);
  ASSERT_EQ(read.types.size(), types_.size());
  EXPECT_EQ(read.types[1].name, "phong#2");
  EXPECT_EQ(read.types[1].merges[3], Merge::representative);
  EXPECT_EQ(read.types[1].shader, types_[1].shader);
}

TEST_F(Cache, HoldsEveryRecordOnceAndPaddingWeighsNothing) {
  const RelightCache cache = make_tile_cache(tile_, types_, {0, 0, 5});
  ASSERT_EQ(cache.tiles().size(), 1u);
  const PackedTile& packed = cache.tiles()[0];
  std::vector<uint32_t> seen(types_.size(), 0);
  for (int b = 0; b < packed.block_count; ++b) {
    const PackedBlock block = cache.block(packed, b);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(block.words) % 64, 0u);
    const float* slot = block.floats();
    for (size_t t = 0; t < types_.size(); ++t) {
      const TypedRows& rows = tile_.types[t];
      for (int s = 0; s < block.slots[t]; ++s) {
        for (int lane = 0; lane < block_lanes; ++lane) {
          const int x = block.pixels[lane] % tile_size;
          const int y = block.pixels[lane] / tile_size;
          const uint32_t row = rows.first[y * tile_.width + x] + static_cast<uint32_t>(s);
          const bool present = lane < block.lanes && row < rows.first[y * tile_.width + x + 1];
          EXPECT_EQ(slot[lane], present ? rows.weights[row] : 0.0f);
          for (int i = 0; i < types_[t].width; ++i) {
            const float value = slot[(1 + i) * block_lanes + lane];
            EXPECT_TRUE(is_finite(value));
            if (present) {
              EXPECT_EQ(value, rows.values[row * types_[t].width + i]);
            }
          }
          seen[t] += present ? 1 : 0;
        }
        slot += (1 + types_[t].width) * block_lanes;
      }
    }
  }
  for (size_t t = 0; t < types_.size(); ++t) EXPECT_EQ(seen[t], tile_.types[t].rows()) << t;
}

TEST_F(Cache, CoverageIsTheSumOfTheWeights) {
  const std::vector<float> coverage = make_tile_cache(tile_, types_, {0, 0, 5}).coverage();
  for (int pixel = 0; pixel < tile_.pixel_count(); ++pixel) {
    double expected = 0;
    for (const TypedRows& rows : tile_.types) {
      for (uint32_t r = rows.first[pixel]; r < rows.first[pixel + 1]; ++r)
        expected += rows.weights[r];
    }
    EXPECT_NEAR(coverage[pixel], expected, 0.5 / 255 + 1e-6);
    EXPECT_EQ(coverage[pixel] > 0, expected > 0);
  }
}

TEST_F(Cache, PredictedErrorIsStoredWhereThereIsGeometry) {
  const std::vector<SampleType> types(types_.begin(), types_.begin() + 2);
  for (const int height : {13, 5, 1}) {  // the floats follow 208, 75 and 15 bytes of coverage
    const int width = height == 13 ? 16 : 15;
    SampleTile tile = make_random_tile(types, width, height, 1, 4);
    fill_predicted_error(tile);
    const RelightCache cache = make_tile_cache(tile, types, {0, 0, 5});
    EXPECT_TRUE(cache.info().has_predicted_error);
    const std::vector<float> coverage = cache.coverage();
    const std::vector<float> error = cache.predicted_error();
    ASSERT_EQ(error.size(), tile.predicted_error.size());
    int covered = 0;
    for (size_t i = 0; i < error.size(); ++i) {
      EXPECT_EQ(error[i], coverage[i] > 0 ? tile.predicted_error[i] : 0.0f) << "pixel " << i;
      covered += coverage[i] > 0 ? 1 : 0;
    }
    EXPECT_GT(covered, 0);
    EXPECT_LT(covered, tile.pixel_count());
  }
  const RelightCache without = make_tile_cache(tile_, types_, {0, 0, 5});
  EXPECT_TRUE(without.predicted_error().empty());
  EXPECT_EQ(without.tiles()[0].predicted_error, nullptr);
}

TEST_F(Cache, PredictedErrorThatIsNotFiniteBecomesTheLargestFloat) {
  fill_predicted_error(tile_);
  const std::vector<float> coverage = make_tile_cache(tile_, types_, {0, 0, 5}).coverage();
  const auto covered =
      std::find_if(coverage.begin(), coverage.end(), [](float c) { return c > 0; });
  const auto pixel = static_cast<size_t>(covered - coverage.begin());
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    tile_.predicted_error[pixel] = bad;
    const std::vector<float> error = make_tile_cache(tile_, types_, {0, 0, 5}).predicted_error();
    EXPECT_EQ(error[pixel], std::numeric_limits<float>::max());
  }
}

TEST_F(Cache, PixelsOfAllTilesFindTheirPlaceInTheImage) {
  SampleTile right = make_random_tile(types_, 3, 13, 3, 2);
  right.x0 = 16;
  CacheWriter writer;
  for (SampleTile* tile : {&tile_, &right}) {
    fill_predicted_error(*tile);
    writer.add(pack_tile(*tile, types_));
  }
  info_.width = 19;
  writer.finish(info_);
  const RelightCache cache =
      RelightCache::from_bytes(writer.take_bytes(), shader_table(), "two tiles");
  const std::vector<float> error = cache.predicted_error();
  const std::vector<float> counts = cache.record_counts();
  ASSERT_EQ(error.size(), 19u * 13);
  ASSERT_EQ(counts.size(), 19u * 13);
  for (const SampleTile* tile : {&tile_, &right}) {
    for (int pixel = 0; pixel < tile->pixel_count(); ++pixel) {
      const int x = tile->x0 + pixel % tile->width;
      const int y = pixel / tile->width;
      uint32_t expected = 0;
      for (const TypedRows& rows : tile->types) {
        expected += rows.first[pixel + 1] - rows.first[pixel];
      }
      EXPECT_EQ(counts[y * 19 + x], static_cast<float>(expected)) << x << ' ' << y;
      EXPECT_EQ(error[y * 19 + x], expected > 0 ? tile->predicted_error[pixel] : 0.0f)
          << x << ' ' << y;
    }
  }
}

TEST(CacheOfNothing, IsValidAndEmpty) {
  const std::vector<SampleType> types = all_sample_types();
  const SampleTile tile = make_random_tile(types, 5, 4, 0, 1);
  const RelightCache cache = make_tile_cache(tile, types, {0, 0, 5});
  EXPECT_EQ(cache.info().record_count, 0u);
  EXPECT_EQ(cache.tiles()[0].block_count, 0);
  EXPECT_EQ(cache.coverage(), std::vector<float>(20, 0.0f));
  EXPECT_EQ(cache.record_counts(), std::vector<float>(20, 0.0f));
}

TEST_F(Cache, InterruptedWriteLeavesTheOldFile) {
  const auto path = folder_.file("a.relume");
  write_all(path, "old");
  {
    CacheWriter writer(path);
    writer.add(pack_tile(tile_, types_));
  }
  EXPECT_EQ(read_all(path), "old");
  EXPECT_EQ(folder_.entry_count(), 1u);
}

TEST(CacheBytesOfAScene, AreTheSameForAnyThreadCount) {
  Scene scene = make_plane_scene(1.2f, vec3(0.5f), 50, 37);
  add_shape(scene, make_sphere({0.4f, 0, 0.5f}, 0.4f, 12, 0));
  std::string first;
  for (const int threads : {1, 2, 3, 8}) {
    set_thread_count(threads);
    const Tracer tracer(scene);
    const ViewSampler view = make_view_sampler(scene, tracer, 50, 37, 7, 2);
    std::vector<PackedTileData> tiles(static_cast<size_t>(tile_count(view)));
    parallel_for(tiles.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        tiles[i] = pack_tile(sample_tile(view, static_cast<int>(i)), view.types.types);
      }
    });
    CacheWriter writer;
    for (const PackedTileData& tile : tiles) writer.add(tile);
    writer.finish(make_cache_info(scene, view.types, 7, 2));
    const std::string bytes = text_of(writer.take_bytes());
    if (threads == 1) first = bytes;
    EXPECT_EQ(bytes, first) << threads << " threads";
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace relume

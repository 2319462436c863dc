#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/relight/frame_cost.h"
#include "tests/support/records.h"

namespace relume {
namespace {

/// A machine of other proportions than the typical one.
double true_ms(const FrameWork& work) {
  const int passes = (work.changed_lights + 3) / 4;
  return 0.1 + 2e-7 * work.records * passes + 1.5e-6 * work.records * work.changed_lights +
         3e-7 * work.pixels * work.changed_lights + 2e-6 * work.pixels * work.combined_layers +
         5e-7 * work.pixels;
}

FrameWork random_work(uint64_t index) {
  Random random(1, RandomStream::tests, index);
  FrameWork work;
  work.pixels = random.uniform(1e5f, 1e6f);
  work.records = work.pixels * static_cast<double>(random.uniform(1, 16));
  work.changed_lights = static_cast<int>(random.below(9));
  work.combined_layers = work.changed_lights + static_cast<int>(random.below(9));
  return work;
}

/// Largest relative error over frames that were not measured.
double largest_error(const FrameCost& cost, double speed = 1) {
  double largest = 0;
  for (uint64_t i = 1000; i < 1200; ++i) {
    const FrameWork work = random_work(i);
    const double exact = true_ms(work) / speed;
    largest = std::max(largest, std::abs(cost.predict_ms(work) / exact - 1));
  }
  return largest;
}

TEST(FrameCost, LearnsRatesFromFramesThatRan) {
  FrameCost cost;
  for (uint64_t i = 0; i < 60; ++i) cost.add_measurement(random_work(i), true_ms(random_work(i)));
  EXPECT_EQ(cost.measurements(), 60);
  EXPECT_LT(largest_error(cost), 0.02);
}

TEST(FrameCost, AveragesNoisyTimes) {
  FrameCost cost;
  for (uint64_t i = 0; i < 300; ++i) {
    Random random(2, RandomStream::tests, i);
    const FrameWork work = random_work(i);
    cost.add_measurement(work, true_ms(work) * static_cast<double>(random.uniform(0.95f, 1.05f)));
  }
  EXPECT_LT(largest_error(cost), 0.05);
}

TEST(FrameCost, FirstFrameScalesEverything) {
  FrameCost typical;
  FrameCost cost;
  const FrameWork work = random_work(5);
  cost.add_measurement(work, 3 * typical.predict_ms(work));
  EXPECT_NEAR(cost.predict_ms(work), 3 * typical.predict_ms(work), 1e-6);
  const FrameWork other = random_work(6);
  EXPECT_NEAR(cost.predict_ms(other) / typical.predict_ms(other), 3, 1e-3);
}

TEST(FrameCost, FollowsAMachineThatSlowsDown) {
  FrameCost cost;
  for (uint64_t i = 0; i < 60; ++i) cost.add_measurement(random_work(i), true_ms(random_work(i)));
  for (uint64_t i = 60; i < 260; ++i) {
    cost.add_measurement(random_work(i), 2 * true_ms(random_work(i)));
  }
  EXPECT_LT(largest_error(cost, 0.5), 0.06);
}

TEST(FrameCost, ManyEqualFramesDoNotWashOutTheOthers) {
  FrameCost cost;
  for (uint64_t i = 0; i < 60; ++i) cost.add_measurement(random_work(i), true_ms(random_work(i)));
  for (int i = 0; i < 5000; ++i) cost.add_measurement(random_work(3), true_ms(random_work(3)));
  EXPECT_LT(largest_error(cost), 0.02);
}

TEST(FrameCost, GrowsWithWorkWhateverWasMeasured) {
  FrameCost cost;
  for (uint64_t i = 0; i < 100; ++i) {
    Random random(3, RandomStream::tests, i);
    cost.add_measurement(random_work(i), static_cast<double>(random.uniform(0.1f, 100)));
    FrameWork work = random_work(i + 1);
    const double less = cost.predict_ms(work);
    EXPECT_GE(less, 0);
    work.changed_lights += 3;
    work.combined_layers += 3;
    work.records *= 2;
    EXPECT_GE(cost.predict_ms(work), less);
  }
  EXPECT_GE(cost.predict_ms({}), 0);
}

TEST(FrameCost, IgnoresTimesThatAreNone) {
  FrameCost cost;
  const double before = cost.predict_ms(random_work(1));
  for (const double ms : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::infinity()}) {
    cost.add_measurement(random_work(1), ms);
  }
  EXPECT_EQ(cost.measurements(), 0);
  EXPECT_EQ(cost.predict_ms(random_work(1)), before);
}

TEST(FrameWork, CountsWhatTheCacheHolds) {
  const std::vector<SampleType> types = test::all_sample_types();
  const SampleTile tile = test::make_random_tile(types, 13, 11, 3, 1);
  const RelightCache cache = test::make_tile_cache(tile, types, {0, 0, 5});
  const FrameWork work = make_frame_work(cache, 2, 5);
  EXPECT_EQ(work.records, static_cast<double>(tile.row_count()));
  EXPECT_EQ(work.pixels, 13 * 11);
  EXPECT_EQ(work.changed_lights, 2);
  EXPECT_EQ(work.combined_layers, 5);
}

}  // namespace
}  // namespace relume

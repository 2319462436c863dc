#include <gtest/gtest.h>

#include "viewer/session/frame_budget.h"

namespace relume {
namespace {

RelightRequest request_of(PixelShare pixels, float x) {
  RelightRequest request;
  request.lights.resize(3);
  request.lights[1].position.x = x;
  request.pixels = pixels;
  return request;
}

/// A frame of a million records in which `changed` lights moved.
RelitFrame frame_of(PixelShare pixels, int changed, double ms) {
  RelitFrame frame;
  frame.request = request_of(pixels, 0);
  frame.work = {1e6 * share_cost(pixels), 1e5, changed, 3};
  frame.ms = ms;
  return frame;
}

TEST(FrameBudget, KnowsNothingBeforeTheFirstFrame) {
  const FrameBudget budget;
  const RelightRequest request = request_of(PixelShare::all, 1);
  EXPECT_FALSE(budget.predict_ms(request, nullptr));
  EXPECT_EQ(budget.choose_pixels(request, nullptr, 40), PixelShare::quarter);
  EXPECT_EQ(budget.choose_pixels(request, nullptr, 0), PixelShare::all);
}

TEST(FrameBudget, PredictsByTheLightsThatChange) {
  FrameBudget budget;
  for (int i = 0; i < 20; ++i) {
    budget.add(frame_of(PixelShare::all, 3, 32));
    budget.add(frame_of(PixelShare::all, 1, 12));
  }
  const RelightRequest shown = request_of(PixelShare::all, 0);
  const RelightRequest moved = request_of(PixelShare::all, 1);
  EXPECT_NEAR(*budget.predict_ms(moved, nullptr), 32, 2);
  EXPECT_NEAR(*budget.predict_ms(moved, &shown), 12, 1);
  EXPECT_EQ(budget.choose_pixels(moved, &shown, 15), PixelShare::all);
  EXPECT_EQ(budget.choose_pixels(moved, &shown, 9), PixelShare::quarter);
  RelightRequest shadowed = moved;
  shadowed.shadows = ShadowMethod::none;
  EXPECT_FALSE(budget.predict_ms(shadowed, &shown)) << "costs of one method say nothing of another";
}

TEST(FrameBudget, IsNotCoarseWhereThatSavesLittle) {
  FrameBudget budget;
  const RelightRequest shown = request_of(PixelShare::all, 0);
  const RelightRequest moved = request_of(PixelShare::all, 1);
  for (int i = 0; i < 5; ++i) {
    budget.add(frame_of(PixelShare::all, 1, 12));
    budget.add(frame_of(PixelShare::quarter, 1, 11));
  }
  EXPECT_EQ(budget.choose_pixels(moved, &shown, 5), PixelShare::all);
  for (int i = 0; i < 5; ++i) budget.add(frame_of(PixelShare::quarter, 1, 4));
  EXPECT_EQ(budget.choose_pixels(moved, &shown, 5), PixelShare::quarter);
}

}  // namespace
}  // namespace relume

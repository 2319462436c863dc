#include <gtest/gtest.h>

#include "viewer/panels/placement.h"

namespace relume {
namespace {

TEST(Layout, PartsCoverTheWindowAtAnySize) {
  for (const vec2 size :
       {vec2(1, 1), vec2(2, 700), vec2(300, 20), vec2(1280, 800), vec2(5000, 3000)}) {
    for (const bool panel : {false, true}) {
      const Layout layout = make_layout(size, 15, panel);
      for (const Rect& part : {layout.menu, layout.picture, layout.panel, layout.status}) {
        EXPECT_GE(part.size().x, 0);
        EXPECT_GE(part.size().y, 0);
      }
      const auto area = [](const Rect& rect) { return rect.size().x * rect.size().y; };
      EXPECT_FLOAT_EQ(
          area(layout.menu) + area(layout.picture) + area(layout.panel) + area(layout.status),
          size.x * size.y);
      EXPECT_GE(layout.picture.size().x, 0.5f * size.x);
    }
  }
}

TEST(Placement, FitShowsTheWholePictureCentred) {
  const Rect area{{100, 50}, {900, 450}};
  const Placement placement = place_picture(area, {1000, 1000}, ViewState{});
  EXPECT_FLOAT_EQ(placement.scale, 0.4f);
  EXPECT_EQ(placement.screen_from_film({0, 0}), vec2(300, 50));
  EXPECT_EQ(placement.screen_from_film({1000, 1000}), vec2(700, 450));
}

TEST(Placement, ZoomKeepsWhatIsUnderThePointer) {
  const Rect area{{0, 0}, {800, 600}};
  ViewState view;
  const vec2 pointer(650, 120);
  Placement placement = place_picture(area, {320, 240}, view);
  const vec2 held = placement.film_from_screen(pointer);
  for (const float factor : {1.3f, 2.0f, 0.7f, 1.1f}) {
    zoom_at(view, placement, pointer, factor);
    placement = place_picture(area, {320, 240}, view);
    // The origin is rounded to whole pixels: half a pixel on the screen each time.
    EXPECT_NEAR(glm::distance(placement.film_from_screen(pointer), held) * placement.scale, 0, 3);
  }
  for (int i = 0; i < 100; ++i) zoom_at(view, placement, pointer, 2);
  EXPECT_LE(view.zoom, 64);
}

TEST(Placement, PanMovesThePictureWithThePointer) {
  const Rect area{{0, 0}, {800, 600}};
  ViewState view;
  const Placement before = place_picture(area, {320, 240}, view);
  pan_by(view, before, vec2(30, -20));
  const Placement after = place_picture(area, {320, 240}, view);
  EXPECT_FLOAT_EQ(after.scale, before.scale);
  EXPECT_NEAR(glm::distance(after.origin - before.origin, vec2(30, -20)), 0, 1);
}

}  // namespace
}  // namespace relume

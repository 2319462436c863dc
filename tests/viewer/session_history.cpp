#include <gtest/gtest.h>

#include <random>

#include "tests/viewer/fake_session.h"
#include "viewer/session/edit_history.h"
#include "viewer/session/light_edits.h"

namespace relume {
namespace {

bool same_edits(const ViewState& a, const ViewState& b) {
  return std::equal(a.lights.begin(), a.lights.end(), b.lights.begin(), b.lights.end(),
                    same_light) &&
         a.solo_lights == b.solo_lights && a.display.exposure == b.display.exposure &&
         a.shadows == b.shadows && a.refine == b.refine;
}

/// One of the things that a person does.
void edit(ViewState& view, const SessionInfo& info, std::mt19937& random) {
  if (!view.lights.empty()) {
    view.selected_light = static_cast<int>(random() % view.lights.size());
  }
  switch (random() % 9) {
    case 0:
      return add_light(view, info.bounds, info.camera);
    case 1:
      return duplicate_light(view);
    case 2:
      return delete_light(view);
    case 3:
      return toggle_solo(view, view.selected_light);
    case 4:
      return rename_light(view, view.selected_light, "name");
    case 5:
      return reorder_light(view, random() % 2 == 0 ? 1 : -1);
    case 6:
      view.display.exposure += 0.25f;
      return;
    case 7:
      view.refine = !view.refine;
      return;
    default:
      if (!view.lights.empty()) view.lights[static_cast<size_t>(view.selected_light)].gain *= 2;
  }
}

TEST(EditHistory, GoesAllTheWayBackAndForth) {
  const SessionParts parts = make_fake_parts();
  ViewState view = parts.view;
  EditHistory history;
  history.reset(view);
  std::vector<ViewState> states{view};
  std::mt19937 random(3);
  for (int i = 0; i < 2000; ++i) {
    edit(view, parts.info, random);
    if (history.commit(view)) states.push_back(view);
  }
  ASSERT_GT(states.size(), 1000u);
  ASSERT_EQ(history.step_count(), states.size() - 1);
  for (size_t i = states.size() - 1; i-- > 0;) {
    ASSERT_TRUE(history.undo(view));
    ASSERT_TRUE(same_edits(view, states[i])) << "state " << i;
    ASSERT_LT(view.selected_light, static_cast<int>(view.lights.size()));
  }
  EXPECT_FALSE(history.undo(view));
  for (size_t i = 1; i < states.size(); ++i) {
    ASSERT_TRUE(history.redo(view));
    ASSERT_TRUE(same_edits(view, states[i])) << "state " << i;
  }
  EXPECT_FALSE(history.redo(view));
}

TEST(EditHistory, LookingIsNoEdit) {
  ViewState view = make_fake_parts().view;
  EditHistory history;
  history.reset(view);
  view.shown = ShownPicture::records;
  view.zoom = 4;
  view.selected_light = 1;
  EXPECT_FALSE(history.commit(view));
  view.lights[1].gain = 3;
  EXPECT_TRUE(history.commit(view));
  EXPECT_TRUE(history.undo(view));
  EXPECT_EQ(view.shown, ShownPicture::records);
  EXPECT_EQ(view.zoom, 4);
  EXPECT_EQ(view.selected_light, 1);
  EXPECT_EQ(view.lights[1].gain, 0.5f);
}

TEST(EditHistory, ANewEditEndsWhatCouldBeRedone) {
  ViewState view = make_fake_parts().view;
  EditHistory history;
  history.reset(view);
  view.lights[0].gain = 2;
  history.commit(view);
  history.undo(view);
  view.lights[0].gain = 3;  // not committed
  EXPECT_FALSE(history.redo(view));
  EXPECT_EQ(view.lights[0].gain, 3);
  EXPECT_TRUE(history.undo(view));
  EXPECT_EQ(view.lights[0].gain, 1);
}

TEST(LightEdits, NamesStayFitForFiles) {
  ViewState view = make_fake_parts().view;
  rename_light(view, 0, "fill");
  EXPECT_EQ(view.lights[0].name, "fill-2");
  rename_light(view, 0, "a.b\n");
  EXPECT_EQ(view.lights[0].name, "a_b?");
  rename_light(view, 0, "  ");
  EXPECT_EQ(view.lights[0].name, "a_b?");
  view.selected_light = 1;
  duplicate_light(view);
  duplicate_light(view);
  EXPECT_EQ(view.lights[2].name, "fill-2");
  EXPECT_EQ(view.lights[3].name, "fill-3");
}

TEST(LightEdits, SoloFollowsItsLight) {
  ViewState view = make_fake_parts().view;
  toggle_solo(view, 1);
  EXPECT_TRUE(shown_lights(view)[0].mute);
  EXPECT_FALSE(shown_lights(view)[1].mute);
  view.selected_light = 0;
  duplicate_light(view);
  EXPECT_EQ(view.solo_lights, std::vector<int>{2});
  delete_light(view);
  EXPECT_EQ(view.solo_lights, std::vector<int>{1});
  view.selected_light = 1;
  reorder_light(view, -1);
  EXPECT_EQ(view.solo_lights, std::vector<int>{0});
  delete_light(view);
  EXPECT_TRUE(view.solo_lights.empty());
  EXPECT_FALSE(shown_lights(view)[0].mute);
}

TEST(LightEdits, LimitsKeepALightValid) {
  const float infinity = std::numeric_limits<float>::infinity();
  Light light;
  light.position = vec3(std::nanf(""), 0, 0);
  light.direction = vec3(0);
  light.gain = infinity;
  light.color = vec3(-1, 2, 1e30f);
  light.outer_angle_deg = 500;
  light.inner_angle_deg = 400;
  limit_light(light, Light{});
  EXPECT_NO_THROW(validate_light(light, "light"));
  EXPECT_EQ(light.gain, 1);
  EXPECT_EQ(light.color, vec3(0, 2, 1e20f));
}

}  // namespace
}  // namespace relume

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "viewer/display/script.h"

namespace relume {
namespace {

TEST(Script, ReadsEveryStep) {
  const Script script = parse_script(
      "# a comment\n"
      "\n"
      "move 10 20.5\n"
      "  move light.gain  \n"
      "move-by -3 4\n"
      "press\r\n"
      "release\n"
      "click view.heatmap\n"
      "drag handle.1 100 -50\n"
      "wheel -2\n"
      "key h\n"
      "type 1.5 2\n"
      "wait\n"
      "resize 640 480\n"
      "screenshot a.png",
      "test");
  ASSERT_EQ(script.steps.size(), 13u);
  EXPECT_EQ(script.steps[0].kind, StepKind::move);
  EXPECT_EQ(script.steps[0].position, vec2(10, 20.5f));
  EXPECT_EQ(script.steps[1].item, "light.gain");
  EXPECT_EQ(script.steps[2].position, vec2(-3, 4));
  EXPECT_EQ(script.steps[6].item, "handle.1");
  EXPECT_EQ(script.steps[6].position, vec2(100, -50));
  EXPECT_EQ(script.steps[9].text, "1.5 2");
  EXPECT_EQ(script.steps[12].text, "a.png");
  EXPECT_EQ(script.steps[12].place, "test:15");
}

TEST(Script, NamesTheLineThatItDoesNotUnderstand) {
  for (const char* line :
       {"jump", "move", "move 1 2 3", "move x y", "move nan 1", "move 1e30 0", "press now",
        "drag handle.1 3", "type", "screenshot a.jpg", "screenshot ../a.png",
        "screenshot /tmp/a.png", "resize 100", "wheel many", "key"}) {
    try {
      parse_script(std::string("wait\n") + line, "script.txt");
      ADD_FAILURE() << "accepted: " << line;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::input);
      EXPECT_NE(std::string(error.what()).find("script.txt:2"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace relume

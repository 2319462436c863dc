// `relume render --frames`: a range of frames that survives kills and failures.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <thread>

#include "core/image/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/child_process.h"
#include "viewer/commands/commands.h"

namespace relume::test {
namespace {

using std::chrono::milliseconds;

const CommonOptions quiet{.quiet = true};

class Frames : public testing::Test {
 protected:
  Frames() {
    render_.input = "spheres";
    render_.output = folder_.file("f.###.exr");
    render_.lights = folder_.file("lights.json");
    render_.frames = FrameRange{1, 6};
    render_.prepare.width = 40;
    render_.prepare.height = 36;
    render_.prepare.spp = 4;
    render_.prepare.records = 3;
    write_lights(R"("position": [0, 4, 3], "gain": 20,
                    "turntable": {"center": [0, 0, 0], "frames": [1, 7]})");
  }

  void write_lights(const std::string& keys) {
    write_all(*render_.lights, "{\"lights\": [{\"name\": \"key\", " + keys + "}]}");
  }

  int render() {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int code = run_render(render_, quiet);
    printed_ = testing::internal::GetCapturedStdout();
    told_ = testing::internal::GetCapturedStderr();
    return code;
  }

  /// How many frames came out so.
  int count(const std::string& fate) const {
    int found = 0;
    for (size_t at = printed_.find(fate); at != std::string::npos;
         at = printed_.find(fate, at + 1)) {
      ++found;
    }
    return found;
  }

  std::string bytes(int frame) const { return read_all(frame_path(render_.output, frame)); }

  TemporaryFolder folder_;
  RenderOptions render_;
  std::string printed_;
  std::string told_;
};

TEST_F(Frames, EachHasItsOwnLightAndCanBeVerified) {
  ASSERT_EQ(render(), 0);
  EXPECT_EQ(count("rendered"), 6);
  for (int frame = 2; frame <= 6; ++frame) EXPECT_NE(bytes(frame), bytes(1)) << frame;
  testing::internal::CaptureStdout();
  EXPECT_EQ(run_verify({.frame = folder_.file("f.004.exr"), .cache = {}}, quiet), 0);
  testing::internal::GetCapturedStdout();
}

TEST_F(Frames, FinishedOnesAreKeptAndOthersMadeAgain) {
  ASSERT_EQ(render(), 0);
  std::vector<std::string> first;
  for (int frame = 1; frame <= 6; ++frame) first.push_back(bytes(frame));
  std::filesystem::remove(folder_.file("f.002.exr"));                             // missing
  write_all(folder_.file("f.003.exr"), first[2].substr(0, first[2].size() / 2));  // cut short
  write_all(folder_.file("f.004.exr"), first[4]);                                 // another frame
  write_all(folder_.file("f.005.exr"), "no picture");
  ASSERT_EQ(render(), 0);
  EXPECT_EQ(count("kept"), 2) << printed_;
  EXPECT_EQ(count("rendered"), 4) << printed_;
  for (int frame = 1; frame <= 6; ++frame) EXPECT_EQ(bytes(frame), first[frame - 1]) << frame;
  render_.shadow = ShadowMethod::none;  // another recipe
  ASSERT_EQ(render(), 0);
  EXPECT_EQ(count("rendered"), 6);
}

TEST_F(Frames, OnesThatFailDoNotLoseTheRest) {
  // The direction passes through zero at frame 3.
  write_lights(
      R"("type": "directional", "keyframes": {"direction": [[1, [0, -2, 0]], [5, [0, 2, 0]]]})");
  render_.frames = FrameRange{1, 5};
  EXPECT_EQ(render(), static_cast<int>(ErrorKind::input));
  EXPECT_EQ(count("rendered"), 4) << printed_;
  EXPECT_NE(told_.find("frame 3: "), std::string::npos) << told_;
  EXPECT_NE(told_.find("1 of 5 frames failed: 3\n"), std::string::npos) << told_;
  EXPECT_FALSE(std::filesystem::exists(folder_.file("f.003.exr")));
  std::filesystem::remove(folder_.file("f.002.exr"));
  std::filesystem::create_directory(folder_.file("f.002.exr"));  // cannot be written
  EXPECT_EQ(render(), static_cast<int>(ErrorKind::output));
  EXPECT_NE(told_.find("2 of 5 frames failed: 2, 3\n"), std::string::npos) << told_;
}

TEST_F(Frames, AfterAKillTheSameCommandGoesOnToTheSameBytes) {
  render_.frames = FrameRange{1, 60};
  ChildProcess child({RELUME_PROGRAM, "render", "spheres", "-o", render_.output.string(),
                      "--lights", render_.lights->string(), "--frames", "1-60", "--width", "40",
                      "--height", "36", "--spp", "4", "--records", "3", "-q"},
                     {}, true);
  ASSERT_TRUE(child.started());
  for (int i = 0; i < 20000 && !std::filesystem::exists(folder_.file("f.003.exr")); ++i) {
    std::this_thread::sleep_for(milliseconds(1));
  }
  child.kill_hard();
  ASSERT_TRUE(std::filesystem::exists(folder_.file("f.003.exr")));
  ASSERT_FALSE(std::filesystem::exists(folder_.file("f.060.exr"))) << "killed too late";
  ASSERT_EQ(render(), 0);
  EXPECT_GE(count("kept"), 3) << printed_;
  EXPECT_GE(count("rendered"), 1) << printed_;
  std::vector<std::string> resumed;
  for (int frame = 1; frame <= 60; ++frame) resumed.push_back(bytes(frame));
  const TemporaryFolder fresh;
  render_.output = fresh.file("f.###.exr");
  ASSERT_EQ(render(), 0);
  EXPECT_EQ(count("rendered"), 60);
  for (int frame = 1; frame <= 60; ++frame) EXPECT_EQ(bytes(frame), resumed[frame - 1]) << frame;
}

TEST_F(Frames, ASceneCarriesItsOwnAnimation) {
  const std::string scene = read_all(RELUME_SOURCE_DIR "/scenes/spheres.json");
  const size_t at = scene.find("\"type\": \"point\"", scene.find("\"lights\""));
  ASSERT_NE(at, std::string::npos);
  write_all(
      folder_.file("scene.json"),
      scene.substr(0, at) + "\"keyframes\": {\"gain\": [[1, 1], [6, 40]]}, " + scene.substr(at));
  render_.input = folder_.file("scene.json").string();
  render_.lights.reset();
  ASSERT_EQ(render(), 0);
  EXPECT_NE(bytes(1), bytes(2));
}

TEST_F(Frames, RangesAndNamesThatMakeNoSenseAreRefused) {
  EXPECT_EQ(parse_frame_range("3-12").count(), 10);
  EXPECT_EQ(parse_frame_range("7").last, 7);
  for (const char* text : {"", "a", "5-3", "-4", "1-", "1-2-3", "1-2x", "0-1000001"}) {
    EXPECT_ERROR(parse_frame_range(text), ErrorKind::usage, "--frames");
  }
  EXPECT_EQ(frame_path("a/b.##.exr", 123), "a/b.123.exr");
  EXPECT_EQ(frame_path("b.####.exr", 7), "b.0007.exr");
  EXPECT_ERROR(frame_path("b.exr", 1), ErrorKind::usage, "####");
  EXPECT_ERROR(frame_path("#b.#.exr", 1), ErrorKind::usage, "####");
  render_.shadow = ShadowMethod::automatic;
  EXPECT_ERROR(render(), ErrorKind::usage, "auto");
  testing::internal::GetCapturedStdout();
  testing::internal::GetCapturedStderr();
}

}  // namespace
}  // namespace relume::test

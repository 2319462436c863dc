// `relume verify`: fresh frames pass, whatever was changed is found.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/image/image_io.h"
#include "core/scene/io/load_scene.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "viewer/commands/commands.h"
#include "viewer/frames/compare_frame.h"
#include "viewer/frames/frame_header.h"

namespace relume::test {
namespace {

const CommonOptions quiet{.quiet = true};

/// What `relume render` was told, for a small picture.
class Verify : public testing::Test {
 protected:
  Verify() {
    render_.input = "spheres";
    render_.output = folder_.file("frame.exr");
    render_.prepare.width = 40;
    render_.prepare.height = 36;
    render_.prepare.spp = 9;
    render_.prepare.records = 3;
    verify_.frame = render_.output;
  }

  void render() {
    testing::internal::CaptureStdout();
    run_render(render_, quiet);
    out();
  }
  int verify(int threads = 0) {
    set_thread_count(threads);
    testing::internal::CaptureStdout();
    const int code = run_verify(verify_, quiet);
    printed_ = out();
    set_thread_count(0);
    return code;
  }

  /// Writes the frame anew with one attribute, or one value of one channel, changed.
  void rewrite(const std::string& attribute, const std::string& text, int changed_channel = -1) {
    const ImageHeader header = read_image_header(verify_.frame);
    std::vector<Image> maps;
    for (const std::string& name : header.channels) {
      maps.push_back(read_exr_channel(verify_.frame, name));
    }
    std::vector<ExrLayer> layers;
    for (size_t c = 0; c < maps.size(); ++c) layers.push_back({"", {header.channels[c]}, &maps[c]});
    if (changed_channel >= 0) {
      float& value = maps[static_cast<size_t>(changed_channel)].pixels[17 * 40 + 23];
      value = std::nextafter(value, 10.0f);
      changed_ = header.channels[static_cast<size_t>(changed_channel)];
    }
    auto metadata = header.metadata;
    for (auto& [name, value] : metadata) {
      if (name == attribute) value = text;
    }
    std::erase_if(metadata, [](const auto& entry) { return !entry.first.starts_with("relume:"); });
    write_exr(verify_.frame, layers, metadata);
  }

  static std::string out() { return testing::internal::GetCapturedStdout(); }

  TemporaryFolder folder_;
  RenderOptions render_;
  VerifyOptions verify_;
  std::string printed_;
  std::string changed_;
};

TEST_F(Verify, AFreshFrameIsTheSameForAnyNumberOfThreads) {
  render_.input = "hair";
  render_.aovs = {FrameAov::position, FrameAov::normal,     FrameAov::albedo,
                  FrameAov::coverage, FrameAov::visibility, FrameAov::error};
  render();
  for (const int threads : {1, 2, 8}) {
    EXPECT_EQ(verify(threads), 0) << threads << "\n" << printed_;
    EXPECT_NE(printed_.find("differing_values   0\n"), std::string::npos) << printed_;
  }
  EXPECT_EQ(read_frame_header(verify_.frame).aovs.size(), 6u);
}

TEST_F(Verify, EveryShadowMethodAndFormatCanBeVerified) {
  for (const ShadowMethod shadow : {ShadowMethod::none, ShadowMethod::coverage}) {
    for (const CacheFormat format : {CacheFormat::exact, CacheFormat::compact}) {
      render_.shadow = shadow;
      render_.prepare.format = format;
      render();
      EXPECT_EQ(verify(), 0) << printed_;
    }
  }
}

TEST_F(Verify, FindsAValueThatIsOffByItsLastBit) {
  render();
  const auto channels = static_cast<int>(read_frame_header(verify_.frame).channels.size());
  for (const int channel : {0, channels - 1}) {
    render();
    rewrite("", "", channel);
    EXPECT_EQ(verify(), 1) << channel;
    EXPECT_NE(printed_.find("differing_values   1\n"), std::string::npos) << printed_;
    EXPECT_NE(printed_.find(
                  fmt::format("{:<18} {}\n{:<18} 23\n{:<18} 17\n", "channel", changed_, "x", "y")),
              std::string::npos)
        << printed_;
  }
}

TEST_F(Verify, FindsAChangedLight) {
  render();
  std::vector<Light> lights = read_frame_header(verify_.frame).lights;
  lights.at(0).position.x *= 1.01f;
  rewrite("relume:lights", format_lights(lights));
  EXPECT_EQ(verify(), 1);
  EXPECT_NE(printed_.find("largest_difference"), std::string::npos) << printed_;
  rewrite("relume:lights", "{\"lights\": []}");
  EXPECT_ERROR(run_verify(verify_, quiet), ErrorKind::input, "is not the frame's");
}

TEST_F(Verify, AnotherCacheIsAnErrorAndItsOwnIsNot) {
  PrepareCommandOptions prepare;
  prepare.scene = render_.input;
  prepare.output = folder_.file("own.relume");
  prepare.prepare = render_.prepare;
  testing::internal::CaptureStdout();
  run_prepare(prepare, quiet);
  prepare.output = folder_.file("other.relume");
  prepare.prepare.records = 2;
  run_prepare(prepare, quiet);
  out();
  render_.input = folder_.file("own.relume").string();
  render();
  verify_.cache = folder_.file("own.relume");
  EXPECT_EQ(verify(), 0) << printed_;
  verify_.cache = folder_.file("other.relume");
  EXPECT_ERROR(run_verify(verify_, quiet), ErrorKind::input, "another cache");
  verify_.cache = folder_.file("absent.relume");
  EXPECT_ERROR(run_verify(verify_, quiet), ErrorKind::input, "absent.relume");
}

TEST_F(Verify, RefusesFramesOfOtherVersionsAndOtherPictures) {
  render();
  rewrite("relume:version", "0.0.1");
  EXPECT_ERROR(read_frame_header(verify_.frame), ErrorKind::input, "rendered by relume 0.0.1");
  render();
  rewrite("relume:spp", "many");
  EXPECT_ERROR(read_frame_header(verify_.frame), ErrorKind::input, "relume:spp");
  const Image grey(4, 4);
  const std::vector<ExrLayer> layers = {{"", {"R", "G", "B"}, &grey}};
  write_exr(verify_.frame, layers);
  EXPECT_ERROR(read_frame_header(verify_.frame), ErrorKind::input, "no frame of relume");
}

}  // namespace
}  // namespace relume::test

// A scene whose materials emit light, through the commands.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/image/image_io.h"
#include "tests/support/oiiotool.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/lamp_scene.h"
#include "viewer/commands/commands.h"

namespace relume::test {
namespace {

const CommonOptions quiet{.quiet = true};

/// The document without the figures that the clock gives.
nlohmann::json without_times(const std::string& text) {
  nlohmann::json document = nlohmann::json::parse(text);
  for (nlohmann::json& row : document.at("rows")) {
    for (const char* prefix : {"ms_", "ratio", "records_per_s", "thread_ms", "coarse_ratio"}) {
      for (auto item = row.begin(); item != row.end();) {
        item = item.key().starts_with(prefix) ? row.erase(item) : std::next(item);
      }
    }
  }
  return document;
}

class EmissionFrame : public testing::Test {
 protected:
  EmissionFrame() {
    write_all(folder_.file("lamp.json"), lamp_scene);
    render_.input = folder_.file("lamp.json").string();
    render_.output = folder_.file("frame.exr");
    render_.prepare.spp = 9;
    render_.prepare.records = 3;
  }

  void silently(const std::function<int()>& command, int expected = 0) {
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    EXPECT_EQ(command(), expected);
    printed_ = testing::internal::GetCapturedStdout();
    told_ = testing::internal::GetCapturedStderr();
  }

  Image layer(const std::string& name) const {
    Image image(48, 40);
    for (int c = 0; c < 3; ++c) {
      const Image channel =
          read_exr_channel(render_.output, name + std::string(1, "RGB"[static_cast<size_t>(c)]));
      for (size_t i = 0; i < channel.pixels.size(); ++i) {
        image.pixels[3 * i + static_cast<size_t>(c)] = channel.pixels[i];
      }
    }
    return image;
  }

  TemporaryFolder folder_;
  RenderOptions render_;
  std::string printed_;
  std::string told_;
};

TEST_F(EmissionFrame, IsALayerThatSumsToBeautyAndIsVerified) {
  silently([&] { return run_render(render_, quiet); });
  EXPECT_NE(told_.find("lights nothing else"), std::string::npos) << told_;
  const Image beauty = layer("");
  const Image emission = layer("emission.");
  const Image key = layer("light.key.");
  const Image rim = layer("light.rim.");
  float brightest = 0;
  for (size_t i = 0; i < beauty.pixels.size(); ++i) {
    const float sum = key.pixels[i] + rim.pixels[i] + emission.pixels[i];
    ASSERT_NEAR(beauty.pixels[i], sum, 1e-5f * sum);
    brightest = std::max(brightest, emission.pixels[i]);
  }
  EXPECT_FLOAT_EQ(brightest, 2);
  silently([&] { return run_verify({.frame = render_.output, .cache = {}}, quiet); });
}

TEST_F(EmissionFrame, IsInTheReference) {
  silently([&] { return run_render(render_, quiet); });
  const Image reduced = layer("emission.");
  render_.reference = true;
  silently([&] { return run_render(render_, quiet); });
  EXPECT_EQ(layer("emission.").pixels, reduced.pixels) << "reduction does not touch it";
}

TEST_F(EmissionFrame, IsInWhatADeepImageFlattensTo) {
  if (!has_oiiotool()) GTEST_SKIP() << "no oiiotool";
  silently([&] { return run_render(render_, quiet); });
  const std::string deep = folder_.file("deep.exr").string();
  const std::string flat = folder_.file("flat.exr").string();
  silently([&] {
    return run_convert({.input = render_.input,
                        .output = deep,
                        .lights = {},
                        .shadow = render_.shadow,
                        .prepare = render_.prepare},
                       quiet);
  });
  ASSERT_TRUE(run_oiiotool(fmt::format("{} --flatten -o {}", deep, flat)));
  const Image frame = layer("");
  const Image found = read_image(flat);
  ASSERT_EQ(found.pixels.size(), frame.pixels.size());
  for (size_t i = 0; i < frame.pixels.size(); ++i) {
    ASSERT_NEAR(found.pixels[i], frame.pixels[i], 0x1p-10f * frame.pixels[i] + 1e-6f) << i;
  }
}

TEST_F(EmissionFrame, IsLeftOutOfStudies) {
  const CommonOptions as_json{.quiet = true, .json = true};
  const std::string text = lamp_scene;
  const std::string dark = std::string(text).replace(text.find("[2, 1, 0.5]"), 11, "0");
  StudyOptions study;
  study.scenes = {render_.input};
  study.spp = 2;
  study.truth_spp = 4;
  study.training_lights = 8;
  study.width = study.height = 32;
  study.lights = 2;
  study.records = {2};
  study.window = 16;
  study.shadows = {ShadowMethod::ray};
  for (const char* name : {"methods", "shadows", "pictures"}) {
    study.name = name;
    study.methods = {ReductionMethod::kmeans};
    write_all(render_.input, text);
    silently([&] { return run_study(study, as_json); });
    EXPECT_NE(told_.find("is left out"), std::string::npos) << name << " " << told_;
    const std::string found = printed_;
    write_all(render_.input, dark);
    silently([&] { return run_study(study, as_json); });
    EXPECT_EQ(told_.find("is left out"), std::string::npos);
    EXPECT_EQ(without_times(found), without_times(printed_)) << name;
  }
}

}  // namespace
}  // namespace relume::test

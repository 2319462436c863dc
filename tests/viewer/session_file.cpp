#include "viewer/session/session_file.h"

#include <gtest/gtest.h>

#include <random>

#include "core/base/error.h"
#include "tests/viewer/fake_session.h"

namespace relume {
namespace {

SessionFile make_file() {
  SessionFile file;
  file.input = "/scenes/a \"b\".json";
  file.seed = 7;
  file.prepare.spp = 9;
  file.prepare.method = ReductionMethod::light_fit;
  file.prepare.records = 4;
  file.prepare.members = 255;
  file.prepare.budget.average_records = 2.5f;
  file.prepare.format = CacheFormat::compact;
  file.prepare.width = 320;
  file.view = std::move(make_fake_parts().view);
  file.view.lights[0].position = vec3(0.1f, -1e-7f, 12345.678f);
  file.view.lights[1].type = LightType::spot;
  file.view.lights[1].mute = true;
  file.view.solo_lights = {1};
  file.view.selected_light = 1;
  file.view.shown = ShownPicture::records;
  file.view.shadows = ShadowMethod::members;
  file.view.display = {.exposure = -1.3f, .curve = ToneCurve::filmic};
  file.view.heat_range = HeatRange::automatic;
  file.view.frame_ms = 17.5f;
  file.view.refine = true;
  file.view.trade = {
      .kind = TradeKind::time, .level = 0.125f, .move_ms = 7.5f, .target_error = 0.03f};
  file.view.records = {2.3f, CacheFormat::compact};
  file.view.zoom = 3.25f;
  file.view.zoom_center_px = vec2(100.5f, -3);
  return file;
}

TEST(SessionFile, ReadsBackWhatItWrote) {
  const SessionFile file = make_file();
  const std::string text = format_session(file);
  EXPECT_TRUE(is_session(text));
  const SessionFile read = parse_session(text, "s.json");
  EXPECT_EQ(format_session(read), text);
  EXPECT_EQ(read.input, file.input);
  EXPECT_EQ(read.prepare.records, file.prepare.records);
  EXPECT_EQ(read.prepare.members, file.prepare.members);
  EXPECT_EQ(read.prepare.method, file.prepare.method);
  EXPECT_EQ(read.view.solo_lights, file.view.solo_lights);
  EXPECT_EQ(read.view.selected_light, 1);
  EXPECT_EQ(read.view.trade, file.view.trade);
  EXPECT_EQ(read.view.records, file.view.records);
  EXPECT_EQ(read.view.zoom_center_px, file.view.zoom_center_px);
  EXPECT_EQ(read.view.display.exposure, file.view.display.exposure);
  ASSERT_EQ(read.view.lights.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_TRUE(same_light(read.view.lights[i], file.view.lights[i])) << i;
  }
}

TEST(SessionFile, WhatIsLeftOutKeepsItsDefault) {
  const SessionFile read =
      parse_session(R"({"schema": "relume-session-1", "input": "hair", "lights": []})", "s.json");
  EXPECT_EQ(read.input, "hair");
  EXPECT_EQ(read.view.selected_light, -1);
  EXPECT_EQ(read.prepare.spp, PrepareOptions{}.spp);
  EXPECT_FALSE(read.prepare.records.has_value());
  EXPECT_TRUE(read.view.solo_lights.empty());
}

/// A wrong session and a part of what is said about it.
struct WrongSession {
  const char* text;
  const char* message;
};

class WrongSessions : public testing::TestWithParam<WrongSession> {};

TEST_P(WrongSessions, AreRefusedWithTheFieldNamed) {
  try {
    parse_session(GetParam().text, "s.json");
    FAIL() << "accepted";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find(GetParam().message), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

#define SESSION_START R"({"schema": "relume-session-1", "input": "hair", "lights": [{"name": "a"}])"

INSTANTIATE_TEST_SUITE_P(
    Fields, WrongSessions,
    testing::Values(
        WrongSession{"", "s.json"}, WrongSession{"[]", "is not an object"},
        WrongSession{R"({"schema": "relume-session-9"})", "/schema"},
        WrongSession{R"({"schema": "relume-session-1"})", "input"},
        WrongSession{R"({"schema": "relume-session-1", "input": 3})", "/input"},
        WrongSession{R"({"schema": "relume-session-1", "input": "hair"})", "lights"},
        WrongSession{SESSION_START R"(, "solo": ["b"]})", "/solo/0"},
        WrongSession{SESSION_START R"(, "selected": "b"})", "/selected"},
        WrongSession{SESSION_START R"(, "selected": 0})", "/selected"},
        WrongSession{SESSION_START R"(, "colour": 0})", "/colour"},
        WrongSession{SESSION_START R"(, "view": {"exposure": 1e9}})", "/view/exposure"},
        WrongSession{SESSION_START R"(, "view": {"zoom": -1}})", "/view/zoom"},
        WrongSession{SESSION_START R"(, "view": {"zoom_center": [1]}})", "/view/zoom_center"},
        WrongSession{SESSION_START R"(, "view": {"shown": "nothing"}})", "/view/shown"},
        WrongSession{SESSION_START R"(, "view": {"refine": 1}})", "/view/refine"},
        WrongSession{SESSION_START R"(, "view": {"trade": "best"}})", "/view/trade"},
        WrongSession{SESSION_START R"(, "view": {"trade_level": 2}})", "/view/trade_level"},
        WrongSession{SESSION_START R"(, "prepare": {"spp": 0}})", "/prepare/spp"},
        WrongSession{SESSION_START R"(, "prepare": {"spp": 2.5}})", "/prepare/spp"},
        WrongSession{SESSION_START R"(, "prepare": {"width": 1000000}})", "/prepare/width"},
        WrongSession{SESSION_START R"(, "prepare": {"members": 256}})", "/prepare/members"},
        WrongSession{SESSION_START R"(, "prepare": {"seed": -1}})", "/prepare/seed"}));

TEST(SessionFile, AnyChangedByteGivesASessionOrOneClearError) {
  const std::string text = format_session(make_file());
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string changed = text;
    const size_t count = 1 + random() % 3;
    for (size_t k = 0; k < count; ++k) {
      changed[random() % changed.size()] = static_cast<char>(random() % 256);
    }
    if (i % 5 == 0) changed.resize(random() % changed.size());
    try {
      const SessionFile read = parse_session(changed, "s.json");
      for (const Light& light : read.view.lights) validate_light(light, "light");
      EXPECT_LT(read.view.selected_light, static_cast<int>(read.view.lights.size()));
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(refused, 1000);
}

TEST(SessionFile, RefusesAHugeText) {
  EXPECT_THROW(parse_session(std::string(max_session_bytes + 1, ' '), "s.json"), Error);
}

}  // namespace
}  // namespace relume

// The curve config in the window: what is shown, exported, rendered and kept.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/image/color_config.h"
#include "core/image/image_io.h"
#include "core/math/color.h"
#include "tests/support/color_config_file.h"
#include "tests/viewer/fake_session.h"
#include "viewer/commands/commands.h"
#include "viewer/commands/relight_input.h"
#include "viewer/session/snapshots.h"
#include "viewer/session/workspace.h"

namespace relume::test {
namespace {

std::vector<uint8_t> shown(const Image& image, const ViewState& view, DisplayQuality quality) {
  std::vector<uint8_t> rgba;
  display_image(image, view, quality, rgba);
  return rgba;
}

OpenedInput open_fake(const SessionFile&, const ProgressCallback&, PreparePreview&) {
  OpenedInput opened;
  opened.session = std::make_unique<Session>(make_fake_parts());
  return opened;
}

/// A session file that shows the curve config.
std::filesystem::path write_session(const TemporaryFolder& folder) {
  SessionFile file;
  file.input = "spheres";
  file.view = make_fake_parts().view;
  file.view.display = {.exposure = 0.5f, .curve = ToneCurve::config};
  write_all(folder.file("session.json"), format_session(file));
  return folder.file("session.json");
}

TEST(ColorOfSessions, AreDraftsWhileALightMovesAndExactAtRest) {
  const ColorConfigFile config;
  Session session(make_fake_parts());
  session.view().display.curve = ToneCurve::config;
  session.wait(true);
  EXPECT_EQ(session.picture().rgba,
            shown(session.frame().image, session.view(), DisplayQuality::exact));
  const uint64_t version = session.picture().version;
  session.wait(false);
  EXPECT_EQ(session.picture().version, version) << "nothing moved: the exact picture stays";

  session.view().lights[0].position.x = 0.4f;
  session.wait(false);
  const auto draft = shown(session.frame().image, session.view(), DisplayQuality::draft);
  const auto exact = shown(session.frame().image, session.view(), DisplayQuality::exact);
  ASSERT_NE(draft, exact) << "or the test could not tell";
  EXPECT_EQ(session.picture().rgba, draft);
  session.wait(true);
  EXPECT_EQ(session.picture().rgba, exact);
}

TEST(ColorOfSessions, SnapshotsFollowAndBecomeExact) {
  const ColorConfigFile config;
  Session session(make_fake_parts());
  session.wait(true);
  Snapshots snapshots;
  snapshots.take(session);
  session.view().display.curve = ToneCurve::config;
  const Image& image = session.frame().image;
  snapshots.follow(session.view(), false);
  EXPECT_EQ(snapshots.current()->picture.rgba, shown(image, session.view(), DisplayQuality::draft));
  snapshots.follow(session.view(), true);
  EXPECT_EQ(snapshots.current()->picture.rgba, shown(image, session.view(), DisplayQuality::exact));
  const uint64_t version = snapshots.current()->picture.version;
  snapshots.follow(session.view(), true);
  EXPECT_EQ(snapshots.current()->picture.version, version) << "repainted without a change";
}

TEST(ColorOfSessions, AreKeptWhereThereIsAConfiguration) {
  const ColorConfigFile config;
  const TemporaryFolder folder;
  Workspace workspace(open_fake, write_session(folder).string(), {});
  workspace.wait(true);
  EXPECT_EQ(workspace.session()->view().display.curve, ToneCurve::config);
  EXPECT_EQ(workspace.notice().text, "");
  ASSERT_TRUE(workspace.save(folder.file("again.json")));
  EXPECT_NE(read_all(folder.file("again.json")).find(R"("curve": "config")"), std::string::npos);
}

TEST(ColorOfSessions, GiveWayToSrgbWithALineWhereThereIsNone) {
  const TemporaryFolder folder;
  Workspace workspace(open_fake, write_session(folder).string(), {});
  workspace.wait(true);
  ASSERT_NE(workspace.session(), nullptr);
  EXPECT_FALSE(workspace.has_config_view());
  EXPECT_EQ(workspace.session()->view().display.curve, ToneCurve::srgb);
  EXPECT_FLOAT_EQ(workspace.session()->view().display.exposure, 0.5f) << "all else is kept";
  EXPECT_TRUE(workspace.notice().is_problem);
  EXPECT_NE(workspace.notice().text.find("set OCIO"), std::string::npos) << workspace.notice().text;
  EXPECT_FALSE(workspace.history().can_undo());
}

TEST(ColorOfSessions, GiveWayToSrgbWhereTheConfigurationIsBroken) {
  const ColorConfigFile config("ocio_profile_version: [");
  const TemporaryFolder folder;
  Workspace workspace(open_fake, write_session(folder).string(), {});
  workspace.wait(true);
  EXPECT_EQ(workspace.session()->view().display.curve, ToneCurve::srgb);
  EXPECT_NE(workspace.notice().text.find("cannot read"), std::string::npos)
      << workspace.notice().text;
}

TEST(ColorOfSessions, AutosavedWorkGivesWayToo) {
  const TemporaryFolder folder;
  const TemporaryFolder state;
  const std::string session = write_session(folder).string();
  const auto move_light = [&](float x) {
    Workspace workspace(open_fake, session, {.state_folder = state.path()});
    workspace.wait(true);
    workspace.session()->view().lights[0].position.x = x;
    workspace.wait(true);
    std::filesystem::copy(state.path(), folder.file("state"),
                          std::filesystem::copy_options::recursive);
  };
  {
    const ColorConfigFile config;
    move_light(0.75f);
  }
  Workspace workspace(open_fake, session, {.state_folder = folder.file("state")});
  workspace.wait(true);
  EXPECT_EQ(workspace.session()->view().lights[0].position.x, 0.75f) << "restored";
  EXPECT_EQ(workspace.session()->view().display.curve, ToneCurve::srgb);
}

TEST(ColorOfSessions, ExportsAreWhatTheWindowShows) {
  const ColorConfigFile config;
  const TemporaryFolder folder;
  const CommonOptions quiet{.quiet = true};
  WorkspaceOptions options{.state_folder = folder.path(), .work_folder = folder.path()};
  options.prepare.width = 48;
  options.prepare.height = 40;
  options.prepare.spp = 4;
  options.prepare.records = 2;
  const InputOpener opener = [&](const SessionFile& file, const ProgressCallback& progress,
                                 PreparePreview&) {
    RelightInput input = open_input(file.input, file.prepare, true, quiet, {progress, {}});
    OpenedInput opened;
    opened.session.reset(new Session(make_session(std::move(input.scene), std::move(input.tracer),
                                                  std::move(*input.cache), std::nullopt)));
    return opened;
  };
  Workspace workspace(opener, "spheres", options);
  workspace.wait(true);
  workspace.session()->view().display = {.exposure = 0.7f, .curve = ToneCurve::config};
  workspace.wait(true);
  const std::vector<uint8_t>& rgba = workspace.session()->picture().rgba;
  workspace.export_frame(folder.file("exported.png"));
  workspace.wait(true);
  const Image exported = read_image(folder.file("exported.png"));
  for (size_t i = 0; i < exported.pixel_count(); ++i) {
    for (int c = 0; c < 3; ++c) {
      // A PNG is read as sRGB.
      const float code = 255 * srgb_from_linear(exported.rgb(i)[c]);
      ASSERT_NEAR(code, rgba[4 * i + static_cast<size_t>(c)], 0.1f) << i;
    }
  }
  std::string command = workspace.copy_command();
  EXPECT_NE(command.find("--curve config"), std::string::npos) << command;
  command.replace(0, 6, RELUME_PROGRAM);
  command.replace(command.rfind("frame.exr"), 9, folder.file("rendered.png").string());
  ASSERT_EQ(std::system((command + " -q >/dev/null").c_str()), 0) << command;
  EXPECT_TRUE(read_all(folder.file("exported.png")) == read_all(folder.file("rendered.png")));
}

}  // namespace
}  // namespace relume::test

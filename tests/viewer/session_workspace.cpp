#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/fake_session.h"
#include "tests/viewer/lamp_scene.h"
#include "viewer/session/prepare.h"
#include "viewer/session/recent_files.h"
#include "viewer/session/workspace.h"

namespace relume {
namespace {

using test::TemporaryFolder;

/// Opens fake sessions; "bad" and "stuck" do what they say.
OpenedInput open_fake(const SessionFile& file, const ProgressCallback& progress, PreparePreview&) {
  if (file.input.ends_with("bad")) throw input_error(file.input, "is bad", "take another");
  while (file.input.ends_with("stuck")) {
    if (!progress("stuck", 0.5, 1)) throw Error(ErrorKind::cancelled, "stopped");
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  OpenedInput opened;
  opened.session = std::make_unique<Session>(make_fake_parts({.reference = false}));
  opened.make_reference = [](const ProgressCallback&) {
    return std::move(make_fake_parts().reference);
  };
  return opened;
}

struct Desk {
  explicit Desk(const std::filesystem::path& state, const std::string& input = "hair")
      : workspace(open_fake, input, {.state_folder = state, .work_folder = state}) {
    workspace.wait(true);
  }
  ViewState& view() { return workspace.session()->view(); }
  /// An edit, as one frame of the window makes it.
  void set_gain(float gain) {
    view().lights[0].gain = gain;
    workspace.wait(true);
  }
  Workspace workspace;
};

TEST(Workspace, OpensInTheBackgroundAndAddsTheReferenceLater) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  ASSERT_NE(desk.workspace.session(), nullptr);
  EXPECT_TRUE(desk.workspace.session()->info().has_reference);
  desk.view().shown = ShownPicture::reference;
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.session()->status().painted, ShownPicture::reference);
}

TEST(Workspace, AFailedFirstInputThrowsWhatItFailedWith) {
  const TemporaryFolder folder;
  Desk desk(folder.path(), "bad");
  EXPECT_EQ(desk.workspace.session(), nullptr);
  EXPECT_THROW(desk.workspace.require_session(), Error);
  EXPECT_TRUE(desk.workspace.notice().is_problem);
}

TEST(Workspace, AFailedLaterInputLeavesWhatIsOpen) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  desk.set_gain(3);
  desk.workspace.open("bad");
  desk.workspace.wait(true);
  ASSERT_NE(desk.workspace.session(), nullptr);
  EXPECT_EQ(desk.view().lights[0].gain, 3);
  EXPECT_NE(desk.workspace.notice().text.find("is bad"), std::string::npos);
  EXPECT_NO_THROW(desk.workspace.require_session());
}

TEST(Workspace, ClosesWhileOpening) {
  const TemporaryFolder folder;
  Workspace workspace(open_fake, "stuck", {.state_folder = folder.path()});
  workspace.update(true);
  EXPECT_EQ(workspace.session(), nullptr);
  workspace.open("stuck");
  workspace.update(true);
}

/// Frames that take a while, and references that take until they may stop; tells that one has
/// begun.
class SlowSource final : public FrameSource {
 public:
  SlowSource(std::unique_ptr<FrameSource> source, std::atomic<int>& begun)
      : source_(std::move(source)), begun_(begun) {}
  void render(const RelightRequest& request, const std::atomic<bool>& cancelled,
              RelitFrame& frame) override {
    ++begun_;
    for (int i = 0; i < 50 && !(request.may_stop && cancelled); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (request.may_stop && cancelled) throw Error(ErrorKind::cancelled, "stopped");
    source_->render(request, cancelled, frame);
  }

 private:
  std::unique_ptr<FrameSource> source_;
  std::atomic<int>& begun_;
};

TEST(Workspace, ClosesWhileAFrameACoarseOneOrTheReferenceIsComputed) {
  std::atomic<int> frames{0};
  std::atomic<int> references{0};
  for (const int moment : {0, 1, 2}) {
    frames = references = 0;
    SessionParts parts = make_fake_parts();
    parts.view.refine = true;
    parts.view.frame_ms = 1;
    parts.frames = std::make_unique<SlowSource>(std::move(parts.frames), frames);
    parts.reference = std::make_unique<SlowSource>(std::move(parts.reference), references);
    Workspace workspace(std::make_unique<Session>(std::move(parts)));
    const auto is_reached = [&] {
      if (moment == 2) return references == 1;
      return moment == 0 ? frames == 1 : frames == 2;  // a quarter, then all of it
    };
    while (!is_reached()) {
      workspace.update(true);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    if (moment == 1) {
      EXPECT_EQ(workspace.session()->status().pixels, PixelShare::quarter);
    }
  }
}

TEST(Workspace, OpensAnotherInputWithoutWaitingForTheOneUnderWay) {
  const TemporaryFolder folder;
  std::atomic<bool> is_held{true};
  const auto opener = [&](const SessionFile& file, const ProgressCallback& progress,
                          PreparePreview& preview) {
    if (!file.input.ends_with("held")) return open_fake(file, progress, preview);
    // Reports nothing, as while a file is read.
    while (is_held) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    throw Error(ErrorKind::cancelled, "stopped");
  };
  Workspace workspace(opener, "held", {.state_folder = folder.path()});
  workspace.open("hair");
  while (workspace.session() == nullptr) {
    workspace.update(true);
    std::this_thread::yield();
  }
  EXPECT_TRUE(is_held) << "the first is still under way";
  is_held = false;
}

TEST(Workspace, ShowsThePreviewAtTheScenesExposure) {
  const TemporaryFolder folder;
  Scene scene = parse_scene(test::lamp_scene, "lamp.json", shader_table());
  scene.exposure = -2;
  PreparePreview same;
  std::atomic<bool> is_prepared{false};
  std::atomic<bool> is_held{true};
  const auto opener = [&](const SessionFile&, const ProgressCallback&,
                          PreparePreview& preview) -> OpenedInput {
    const Tracer tracer(scene);
    PrepareParams params;
    params.spp = 4;
    params.on_tile = [&](const ViewSampler& view, const SampleTile& records) {
      preview.add_tile(view, records);
      same.add_tile(view, records);
    };
    prepare_in_memory(scene, tracer, params, {});
    is_prepared = true;
    while (is_held) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    throw Error(ErrorKind::cancelled, "stopped");
  };
  Workspace workspace(opener, "lamp", {.state_folder = folder.path()});
  while (!is_prepared) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  workspace.update(true);
  is_held = false;
  Image image;
  float exposure = 0;
  ASSERT_TRUE(same.take(image, exposure));
  std::vector<uint8_t> expected(4 * image.pixel_count());
  apply_display_rgba(image, {.exposure = -2, .curve = default_curve()}, expected);
  EXPECT_TRUE(workspace.preview().rgba == expected);
  EXPECT_GT(*std::max_element(image.pixels.begin(), image.pixels.end()), 0);
}

TEST(Workspace, OneDragIsOneStep) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  for (int i = 1; i < 10; ++i) {
    desk.view().lights[0].position.x = static_cast<float>(i);
    desk.workspace.update(false);
  }
  desk.workspace.update(true);
  EXPECT_EQ(desk.workspace.history().step_count(), 1u);
  desk.workspace.undo();
  EXPECT_EQ(desk.view().lights[0].position.x, 0);
  desk.workspace.redo();
  EXPECT_EQ(desk.view().lights[0].position.x, 9);
}

TEST(Workspace, KnowsWhatIsNotSaved) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  EXPECT_FALSE(desk.workspace.is_modified());
  desk.set_gain(3);
  EXPECT_TRUE(desk.workspace.is_modified());
  ASSERT_TRUE(desk.workspace.save(folder.file("mine")));
  EXPECT_EQ(desk.workspace.document().filename(), "mine.json");
  EXPECT_FALSE(desk.workspace.is_modified());
  desk.workspace.undo();
  EXPECT_TRUE(desk.workspace.is_modified());
  desk.set_gain(4);  // as many steps as were saved, but others
  EXPECT_TRUE(desk.workspace.is_modified());
}

TEST(Workspace, ASavedSessionComesBack) {
  const TemporaryFolder folder;
  {
    Desk desk(folder.path());
    desk.set_gain(3);
    desk.view().display.exposure = 1.5f;
    ASSERT_TRUE(desk.workspace.save(folder.file("mine.json")));
  }
  Desk desk(folder.path(), folder.file("mine.json").string());
  EXPECT_EQ(desk.view().lights[0].gain, 3);
  EXPECT_EQ(desk.view().display.exposure, 1.5f);
  EXPECT_EQ(desk.workspace.snapshot().input, "hair");
  EXPECT_FALSE(desk.workspace.is_modified());
}

TEST(Workspace, SavingWhereItCannotIsANotice) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  EXPECT_FALSE(desk.workspace.save(folder.path() / "missing" / "mine.json"));
  EXPECT_TRUE(desk.workspace.notice().is_problem);
  EXPECT_TRUE(desk.workspace.document().empty());
}

TEST(Workspace, WorkThatWasNotSavedIsRestoredAfterAKill) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  // The same folder in the process that ends, which runs the test from its beginning.
  const TemporaryFolder folder;
  setenv("RELUME_TEST_STATE", folder.path().c_str(), 0);
  const std::filesystem::path state = std::getenv("RELUME_TEST_STATE");
  EXPECT_EXIT(
      {
        Desk desk(state);
        desk.set_gain(3);
        std::_Exit(9);  // nothing is tidied up
      },
      testing::ExitedWithCode(9), "");
  {
    Desk desk(state);
    EXPECT_EQ(desk.view().lights[0].gain, 3);
    EXPECT_NE(desk.workspace.notice().text.find("restored"), std::string::npos);
    desk.workspace.undo();
    EXPECT_EQ(desk.view().lights[0].gain, 1);
  }
  unsetenv("RELUME_TEST_STATE");
}

TEST(Workspace, LeavingKeepsTheWorkAsTheLastSession) {
  const TemporaryFolder folder;
  {
    Desk desk(folder.path());
    desk.set_gain(3);
  }
  EXPECT_FALSE(std::filesystem::exists(autosave_file(folder.path(), "hair")));
  Desk fresh(folder.path());
  EXPECT_EQ(fresh.view().lights[0].gain, 1);
  const std::vector<std::string> recent = fresh.workspace.recent_files();
  ASSERT_EQ(recent.size(), 2u);
  EXPECT_EQ(recent[0], "hair");
  Desk last(folder.path(), recent[1]);
  EXPECT_EQ(last.view().lights[0].gain, 3);
}

TEST(Workspace, ABrokenAutosaveIsANoticeAndNoMore) {
  const TemporaryFolder folder;
  write_file_atomic(autosave_file(folder.path(), "hair"), std::string("{\"schema\": \"relume-s"));
  Desk desk(folder.path());
  ASSERT_NE(desk.workspace.session(), nullptr);
  EXPECT_TRUE(desk.workspace.notice().is_problem);
  EXPECT_EQ(desk.view().lights[0].gain, 1);
}

TEST(Workspace, TakesTheLightsOfALightFile) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  write_file_atomic(folder.file("l.json"),
                    std::string(R"({"lights": [{"name": "only", "gain": 5}]})"));
  desk.workspace.open(folder.file("l.json").string());
  desk.workspace.wait(true);
  ASSERT_EQ(desk.view().lights.size(), 1u);
  EXPECT_EQ(desk.view().lights[0].gain, 5);
  desk.workspace.undo();
  EXPECT_EQ(desk.view().lights.size(), 2u);
}

TEST(RecentFiles, AreNewestFirstOnceAndTen) {
  const TemporaryFolder folder;
  for (int i = 0; i < 14; ++i) add_recent_file(folder.path(), fmt::format("f{}", i % 12));
  const std::vector<std::string> files = read_recent_files(folder.path());
  ASSERT_EQ(files.size(), 10u);
  EXPECT_EQ(files[0], "f1");
  EXPECT_EQ(files[1], "f0");
  EXPECT_EQ(files[2], "f11");
  write_file_atomic(folder.file("recent.json"), std::string("[3]"));
  EXPECT_TRUE(read_recent_files(folder.path()).empty());
}

}  // namespace
}  // namespace relume

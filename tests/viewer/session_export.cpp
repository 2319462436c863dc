// What the viewer exports against what the command that it copies renders.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/image/image_io.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "viewer/commands/relight_input.h"
#include "viewer/session/render_command.h"
#include "viewer/session/workspace.h"

namespace relume {
namespace {

using test::read_all;
using test::TemporaryFolder;

const CommonOptions quiet{.quiet = true};

OpenedInput open_quietly(const SessionFile& file, const ProgressCallback& progress,
                         PreparePreview&) {
  RelightInput input = open_input(file.input, file.prepare, true, quiet, {progress, {}});
  OpenedInput opened;
  opened.session.reset(new Session(make_session(std::move(input.scene), std::move(input.tracer),
                                                std::move(*input.cache), std::nullopt)));
  const Session& session = *opened.session;
  PrepareOptions all = file.prepare;
  all.method = ReductionMethod::all;
  opened.make_reference = [&session, params = make_prepare_params(all, quiet)](const auto& report) {
    const Tracer& tracer = *session.tracer();
    return make_cache_source(prepare_in_memory(tracer.scene(), tracer, params, report), &tracer,
                             ShadowMethod::ray);
  };
  return opened;
}

class Export : public testing::Test {
 protected:
  Export() : workspace_(open_quietly, "spheres", options(folder_.path())) {
    workspace_.wait(true);
    ViewState& view = workspace_.session()->view();
    view.lights[0].position.x += 0.3f;
    view.lights[0].color = vec3(0.9f, 0.7f, 0.1f);
    view.lights.push_back(view.lights[0]);
    view.lights.back().name = "a second";
    view.lights.back().position.y += 0.7f;
    view.display = {.exposure = 0.7f, .curve = ToneCurve::filmic};
    workspace_.wait(true);
  }

  static WorkspaceOptions options(const std::filesystem::path& folder) {
    WorkspaceOptions options{.state_folder = folder, .work_folder = folder};
    options.prepare.width = 48;
    options.prepare.height = 40;
    options.prepare.spp = 4;
    options.prepare.records = 2;
    return options;
  }

  /// Exports the picture, renders it with the copied command, and compares the files.
  void expect_same_bytes(const std::string& extension) {
    const std::filesystem::path exported = folder_.file("exported" + extension);
    workspace_.export_frame(exported);
    workspace_.wait(true);
    ASSERT_FALSE(workspace_.notice().is_problem) << workspace_.notice().text;
    std::string command = workspace_.copy_command();
    ASSERT_TRUE(command.starts_with("relume render spheres ")) << command;
    const std::string rendered = "rendered" + extension;
    command.replace(0, 6, RELUME_PROGRAM);
    command.replace(command.rfind("frame.exr"), 9, rendered);
    command = fmt::format("cd '{}' && {} -q >/dev/null", folder_.path().string(), command);
    ASSERT_EQ(std::system(command.c_str()), 0) << command;
    const std::string bytes = read_all(exported);
    EXPECT_GT(bytes.size(), 500u);
    EXPECT_TRUE(bytes == read_all(folder_.file(rendered))) << command;
  }

  TemporaryFolder folder_;
  Workspace workspace_;
};

TEST_F(Export, TheCopiedCommandRendersTheSameBytes) {
  expect_same_bytes(".exr");
  expect_same_bytes(".png");
  const auto names = read_channel_names(folder_.file("exported.exr"));
  EXPECT_NE(std::find(names.begin(), names.end(), "light.a_second.R"), names.end());
}

TEST_F(Export, SoloAndOtherShadowsGoIntoTheCommand) {
  workspace_.session()->view().solo_lights = {
      static_cast<int>(workspace_.session()->view().lights.size()) - 1};
  workspace_.session()->view().shadows = ShadowMethod::none;
  workspace_.wait(true);
  expect_same_bytes(".exr");
  const Image light = read_exr_layer(folder_.file("exported.exr"), "light.a_second.");
  const Image frame = read_image(folder_.file("exported.exr"));
  EXPECT_EQ(light.pixels, frame.pixels);
}

TEST_F(Export, TheReferenceIsRenderedAsOne) {
  workspace_.session()->view().shown = ShownPicture::reference;
  workspace_.wait(true);
  ASSERT_TRUE(shows_all_samples(*workspace_.session()));
  expect_same_bytes(".exr");
  EXPECT_NE(workspace_.copy_command().find("--reference"), std::string::npos);
}

TEST(ExportOfACache, TheReferenceIsThatOfItsBuiltInScene) {
  const TemporaryFolder folder;
  const WorkspaceOptions options{.state_folder = folder.path(), .work_folder = folder.path()};
  PrepareOptions small;
  small.width = small.height = 16;
  small.spp = 2;
  small.records = 1;
  const Scene scene = load_scene("spheres", shader_table());
  const Tracer tracer(scene);
  prepare_to_file(scene, tracer, make_prepare_params(small, quiet), folder.file("made.relume"), {});
  Workspace workspace(open_quietly, folder.file("made.relume").string(), options);
  workspace.wait(true);
  workspace.session()->view().shown = ShownPicture::reference;
  workspace.wait(true);
  EXPECT_EQ(workspace.copy_command().find("relume render spheres --reference"), 0u)
      << workspace.copy_command();
}

TEST_F(Export, ANewNameEachTimeAndAProblemIsANotice) {
  workspace_.export_next_frame();
  workspace_.wait(true);
  workspace_.export_next_frame();
  workspace_.wait(true);
  EXPECT_TRUE(std::filesystem::exists(folder_.file("spheres-001.exr")));
  EXPECT_TRUE(std::filesystem::exists(folder_.file("spheres-002.exr")));
  workspace_.export_frame(folder_.path() / "missing" / "frame.exr");
  workspace_.wait(true);
  EXPECT_TRUE(workspace_.notice().is_problem);
  workspace_.export_frame(folder_.file("frame.tiff"));
  workspace_.wait(true);
  EXPECT_NE(workspace_.notice().text.find(".exr or .png"), std::string::npos);
}

TEST(ShellQuoted, LeavesPlainWordsAndQuotesTheRest) {
  EXPECT_EQ(shell_quoted("a/b-c_1.json"), "a/b-c_1.json");
  EXPECT_EQ(shell_quoted(""), "''");
  EXPECT_EQ(shell_quoted("a b"), "'a b'");
  EXPECT_EQ(shell_quoted("it's $HOME;"), "'it'\\''s $HOME;'");
}

}  // namespace
}  // namespace relume

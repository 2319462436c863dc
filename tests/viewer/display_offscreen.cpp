#include <fmt/format.h>
#include <gtest/gtest.h>
#include <imgui.h>

#include <fstream>
#include <sstream>

#include "core/base/error.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/display_soak.h"
#include "tests/viewer/fake_session.h"
#include "viewer/display/osmesa_surface.h"
#include "viewer/display/run_viewer.h"
#include "viewer/display/script_player.h"
#include "viewer/session/prepare.h"

namespace relume {
namespace {

std::string read_bytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

std::filesystem::path fresh_folder(const std::string& name) {
  static const test::TemporaryFolder of_this_process;
  const std::filesystem::path folder = of_this_process.file(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// The viewer off screen, kept between scripts so that a test can look inside.
struct Stage {
  explicit Stage(ivec2 size_px = {1280, 800}, const FakeSessionOptions& options = {})
      : Stage(std::make_unique<Session>(make_fake_parts(options)), size_px) {}
  explicit Stage(std::unique_ptr<Session> opened, ivec2 size_px = {1280, 800})
      : workspace(std::move(opened)),
        session(*workspace.session()),
        surface(size_px),
        gl(load_gl_table(surface.loader())),
        screen(workspace, gl, {.scale = 1, .show_timings = false}) {}

  void play(const std::string& text) {
    play_script(parse_script(text, "test"), workspace, screen, gl, surface, folder.path());
  }
  DisplayImage look() const { return read_framebuffer(gl, surface.size_px()); }
  vec2 center(const std::string& item) const {
    const auto rect = screen.ui().items.find(item);
    EXPECT_TRUE(rect.has_value()) << item << " is not among " << screen.ui().items.names();
    return rect ? rect->center() : vec2(0);
  }

  const test::TemporaryFolder folder;  // of screenshots
  Workspace workspace;
  Session& session;
  OsmesaSurface surface;
  GlTable gl;
  Screen screen;
};

/// The built-in spheres, small, with their ray tracer.
std::unique_ptr<Session> open_spheres() {
  auto scene = std::make_unique<const Scene>(load_scene("spheres", shader_table()));
  auto tracer = std::make_unique<const Tracer>(*scene);
  PrepareParams params;
  params.spp = 4;
  params.reduction.records = 2;
  params.width = params.height = 64;
  RelightCache cache = prepare_in_memory(*scene, *tracer, params, {});
  return std::unique_ptr<Session>(
      new Session(make_session(std::move(scene), std::move(tracer), std::move(cache), {})));
}

TEST(Offscreen, DrawsWithoutThreadsOfMesa) {
  if (const char* threads = std::getenv("LP_NUM_THREADS"); threads && std::string(threads) != "0") {
    GTEST_SKIP() << "asked for otherwise";
  }
  Stage stage;
  stage.play("wait");
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    std::ifstream stream(task.path() / "comm");
    std::string name;
    std::getline(stream, name);
    EXPECT_FALSE(name.starts_with("llvmpipe")) << name;
  }
}

TEST(Offscreen, DragMovesTheLightInTheViewPlane) {
  Stage stage;
  stage.play("wait");
  const vec2 from = stage.center("handle.1");
  const std::vector<uint8_t> before = stage.session.picture().rgba;
  stage.play("drag handle.1 90 -60\nwait");

  const vec2 to = stage.center("handle.1");
  EXPECT_NEAR(to.x - from.x, 90, 0.1);
  EXPECT_NEAR(to.y - from.y, -60, 0.1);
  // Light 1 starts at the origin, 5 in front of the eye, in the middle of a 240 pixel high picture
  // with a field of view of 35 degrees; the picture is shown `scale` times enlarged.
  const float scale =
      glm::distance(stage.center("handle.2"), from) /
      glm::distance(stage.session.rays().project(vec3(-1, 0.75f, 0.5f)).film_px, vec2(160, 120));
  const float world_per_screen = 2 * 5 * std::tan(radians_from_degrees(17.5f)) / (240 * scale);
  const vec3 position = stage.session.view().lights[0].position;
  EXPECT_NEAR(position.x, 90 * world_per_screen, 2e-3);
  EXPECT_NEAR(position.y, 60 * world_per_screen, 2e-3);
  EXPECT_NEAR(position.z, 0, 1e-6);
  EXPECT_NE(stage.session.picture().rgba, before);
}

TEST(Offscreen, DragAlongAnAxisLeavesTheOthers) {
  Stage stage;
  stage.play("wait\ndrag axis.y 15 -40\nwait");
  const vec3 position = stage.session.view().lights[0].position;
  EXPECT_EQ(position.x, 0);
  EXPECT_EQ(position.z, 0);
  EXPECT_GT(position.y, 0.05f);
}

TEST(Offscreen, PressWithoutMotionSelectsAndMovesNothing) {
  Stage stage;
  const vec3 before = stage.session.view().lights[1].position;
  stage.play("click handle.2");
  EXPECT_EQ(stage.session.view().selected_light, 1);
  EXPECT_EQ(stage.session.view().lights[1].position, before);
}

TEST(Offscreen, RestsOnlyWhenNoLightIsHeld) {
  Stage stage;
  stage.play("move handle.1\npress\nmove-by 5 5");
  EXPECT_FALSE(stage.screen.resting());
  stage.play("release");
  EXPECT_TRUE(stage.screen.resting());
}

TEST(Offscreen, ClicksByNameChangeTheView) {
  Stage stage;
  const ViewState& view = stage.session.view();
  stage.play("click view.heatmap\nclick heatmap.auto\nclick shadows.none\nclick view.curve.filmic");
  EXPECT_EQ(view.shown, ShownPicture::heatmap);
  EXPECT_EQ(view.heat_range, HeatRange::automatic);
  EXPECT_EQ(view.shadows, ShadowMethod::none);
  EXPECT_EQ(view.display.curve, ToneCurve::filmic);
  stage.play("click lights.2\nclick lights.2.mute\nclick light.type.spot\nclick light.falloff");
  EXPECT_EQ(view.selected_light, 1);
  EXPECT_TRUE(view.lights[1].mute);
  EXPECT_EQ(view.lights[1].type, LightType::spot);
  EXPECT_FALSE(view.lights[1].falloff);
  const float gain = view.lights[1].gain;
  stage.play("drag light.gain 50 0");
  EXPECT_NEAR(std::log2(view.lights[1].gain / gain), 1, 0.1) << "0.02 stops a pixel";
}

TEST(Offscreen, KeysChangeTheView) {
  Stage stage;
  const ViewState& view = stage.session.view();
  stage.play("key 2\nkey m\nkey h\nkey +\nkey =\nkey +\nkey -\nkey s\nkey 9");
  EXPECT_EQ(view.selected_light, 1);
  EXPECT_TRUE(view.lights[1].mute);
  EXPECT_EQ(view.shown, ShownPicture::heatmap);
  EXPECT_FLOAT_EQ(view.display.exposure, 1);
  EXPECT_EQ(view.shadows, ShadowMethod::none);
  EXPECT_FALSE(stage.screen.quit());
  stage.play("key q\nkey f");
  EXPECT_TRUE(stage.screen.quit());
  EXPECT_EQ(view.shown, ShownPicture::heatmap) << "nothing happens after quitting";
}

/// How many pixels differ between two pictures of the window.
size_t changed_pixels(const DisplayImage& a, const DisplayImage& b) {
  size_t count = 0;
  for (size_t i = 0; i < a.pixels.size(); i += a.channels) {
    count += std::equal(&a.pixels[i], &a.pixels[i] + 3, &b.pixels[i]) ? 0 : 1;
  }
  return count;
}

TEST(Offscreen, MapsOfThePixelsHaveKeysButtonsAndAScale) {
  Stage stage;
  const ViewState& view = stage.session.view();
  stage.play("key e\nwait");
  EXPECT_EQ(view.shown, ShownPicture::predicted);
  const DisplayImage predicted = stage.look();
  stage.play("click view.records\nwait");
  EXPECT_EQ(view.shown, ShownPicture::records);
  EXPECT_GT(changed_pixels(predicted, stage.look()), 100000u);
  stage.play("key f");
  EXPECT_EQ(view.shown, ShownPicture::frame);
  stage.play("key k");
  EXPECT_EQ(view.shown, ShownPicture::records);
  stage.play("click view.predicted\nclick heatmap.auto\nmove 5 5");
  EXPECT_EQ(view.shown, ShownPicture::predicted);
  EXPECT_GT(changed_pixels(predicted, stage.look()), 50000u);
}

TEST(Offscreen, SaysThatTheCacheHoldsNoPredictedError) {
  Stage stage({1280, 800}, {.predicted_error = false});
  stage.play("click view.frame\nmove 5 790");
  const DisplayImage frame = stage.look();
  stage.play("key e\nwait");
  EXPECT_EQ(stage.session.view().shown, ShownPicture::predicted);
  const DisplayImage missing = stage.look();
  // A line in the picture's top left corner, and the lit button; the rest is the frame.
  size_t line = 0;
  for (size_t y = 0; y < 40; ++y) {
    for (size_t x = 60; x < 400; ++x) {
      const size_t i = missing.channels * (y * missing.width + x);
      const bool same = std::equal(&frame.pixels[i], &frame.pixels[i] + 3, &missing.pixels[i]);
      line += same ? 0 : 1;
    }
  }
  EXPECT_GT(line, 300u);
  EXPECT_LT(changed_pixels(frame, missing), line + 8000);
}

TEST(Offscreen, UndoTakesBackADragAsOneStep) {
  Stage stage;
  const vec3 before = stage.session.view().lights[0].position;
  stage.play("drag handle.1 90 -60");
  const vec3 after = stage.session.view().lights[0].position;
  EXPECT_NE(after, before);
  EXPECT_EQ(stage.workspace.history().step_count(), 1u);
  stage.play("key ctrl+z");
  EXPECT_EQ(stage.session.view().lights[0].position, before);
  stage.play("key ctrl+shift+z");
  EXPECT_EQ(stage.session.view().lights[0].position, after);
  stage.play("click menu.edit\nclick menu.undo");
  EXPECT_EQ(stage.session.view().lights[0].position, before);
}

TEST(Offscreen, KeysEditTheListOfLights) {
  Stage stage;
  const ViewState& view = stage.session.view();
  stage.play("key a\nkey ctrl+d");
  ASSERT_EQ(view.lights.size(), 4u);
  EXPECT_EQ(view.selected_light, 3);
  stage.play("key o\nkey [\nkey .\nkey .");
  EXPECT_EQ(view.solo_lights, std::vector<int>{3});
  EXPECT_NEAR(std::log2(view.lights[2].gain / view.lights[3].gain), 0.5, 1e-5);
  stage.play("key delete\nkey delete\nkey delete\nkey delete\nkey delete");
  EXPECT_TRUE(view.lights.empty());
  EXPECT_EQ(view.selected_light, -1);
  stage.play("key ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z");
  EXPECT_EQ(view.lights.size(), 4u);
  EXPECT_EQ(view.solo_lights, std::vector<int>{3});
}

TEST(Offscreen, ArrowKeysMoveTheLight) {
  Stage stage;
  const Light& light = stage.session.view().lights[0];
  stage.play("key right\nkey up\nkey up");
  EXPECT_GT(light.position.x, 0);
  EXPECT_NEAR(light.position.y, 2 * light.position.x, 1e-6);
  EXPECT_EQ(light.position.z, 0);
  stage.play("key page-up");
  EXPECT_LT(light.position.z, 0) << "away from the eye";
  EXPECT_EQ(stage.workspace.history().step_count(), 4u);
}

TEST(Offscreen, TheSessionIsSavedThroughTheBox) {
  const std::filesystem::path folder = fresh_folder("relume_save");
  Stage stage;
  stage.play(fmt::format("key ctrl+s\ntype {}\nkey enter", (folder / "mine").string()));
  EXPECT_EQ(stage.workspace.document(), folder / "mine.json");
  EXPECT_NE(read_bytes(folder / "mine.json").find("relume-session-1"), std::string::npos);
  stage.play("key .\nkey ctrl+s");
  EXPECT_FALSE(stage.workspace.is_modified());
  EXPECT_EQ(read_bytes(folder / "mine.json").find("\"gain\": 1,"), std::string::npos);
  stage.play("key ctrl+shift+s\nclick dialog.entry.mine.json\nclick dialog.cancel");
  EXPECT_FALSE(stage.screen.ui().items.find("dialog.path").has_value());
}

TEST(Offscreen, ColorTemperatureAndNameOfALight) {
  Stage stage;
  const ViewState& view = stage.session.view();
  stage.play("drag light.kelvin -40 0");
  const vec3 warm = view.lights[0].color;
  EXPECT_GT(warm.x, warm.z);
  EXPECT_EQ(stage.workspace.history().step_count(), 1u);
  stage.play("click light.name\nkey ctrl+a\ntype sun.1\nkey enter");
  EXPECT_EQ(view.lights[0].name, "sun_1");
  stage.play("click lights.2.solo\nclick lights.1.solo\nclick lights.1.solo");
  EXPECT_EQ(view.solo_lights, std::vector<int>{1});
  stage.play("click lights.add\nclick lights.copy\nclick lights.1\nclick lights.delete");
  EXPECT_EQ(view.lights.size(), 3u);
  EXPECT_EQ(view.solo_lights, std::vector<int>{0});
}

TEST(Offscreen, ASpotsConesAndAimAreDragged) {
  Stage stage;
  Light& spot = stage.session.view().lights[0];
  spot.type = LightType::spot;
  spot.position = vec3(-1.5f, 0.8f, 0);
  spot.direction = vec3(1, -0.5f, -0.2f);
  spot.outer_angle_deg = 20;
  spot.inner_angle_deg = 12;
  stage.play("wait");
  const auto drag_outwards = [&stage](const std::string& item, float pixels) {
    const vec2 outwards = glm::normalize(stage.center(item) - stage.center("spot.aim")) * pixels;
    stage.play(fmt::format("drag {} {:.0f} {:.0f}", item, outwards.x, outwards.y));
  };
  drag_outwards("spot.outer", 20);
  EXPECT_GT(spot.outer_angle_deg, 21);
  EXPECT_EQ(spot.inner_angle_deg, 12);
  drag_outwards("spot.inner", -15);
  EXPECT_LT(spot.inner_angle_deg, 11.5f);
  const vec2 before = stage.center("spot.aim");
  stage.play("drag spot.aim -30 25");
  EXPECT_NEAR(glm::distance(stage.center("spot.aim"), before + vec2(-30, 25)), 0, 15)
      << "what it is aimed at lies at another depth";
  EXPECT_EQ(spot.position, vec3(-1.5f, 0.8f, 0));
  EXPECT_EQ(stage.workspace.history().step_count(), 4u) << "the spot itself, and three drags";
  const float distance = glm::distance(spot.position, vec3(0));
  stage.play("drag axis.aim -30 15");
  EXPECT_GT(glm::distance(spot.position, vec3(0)), distance);
}

TEST(Offscreen, AClickPutsTheHighlightThere) {
  Stage stage(open_spheres());
  const Light& light = stage.session.view().lights[0];
  const Light start = light;
  stage.play("click tool.highlight\nclick 480 330");
  const vec2 film = stage.screen.ui().placement.film_from_screen(vec2(480, 330));
  const auto surface = find_surface(*stage.session.tracer(), stage.session.rays(), film);
  ASSERT_TRUE(surface.has_value());
  const vec3 wi = glm::normalize(light.position - surface->position);
  const vec3 wo = glm::normalize(stage.session.rays().eye() - surface->position);
  EXPECT_NEAR(glm::distance(glm::normalize(wi + wo), surface->shading_normal), 0, 1e-4);
  EXPECT_EQ(stage.workspace.history().step_count(), 1u);
  stage.play("key escape\nclick 400 330");
  EXPECT_EQ(stage.workspace.history().step_count(), 1u) << "the tool was left";
  stage.play("key ctrl+z");
  EXPECT_TRUE(same_light(light, start));
  stage.play("key j\nclick 480 300");
  EXPECT_EQ(stage.workspace.history().step_count(), 0u) << "nothing to drag in the light";
}

/// The first three channels of the window's pixel at a place.
vec3 pixel_at(const DisplayImage& image, vec2 place) {
  const size_t i =
      image.channels * (static_cast<size_t>(place.y) * image.width + static_cast<size_t>(place.x));
  return {image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]};
}

TEST(Offscreen, SnapshotsFlipAndWipe) {
  Stage stage;
  const vec2 left(200, 400);
  const vec2 right(800, 400);
  stage.play("move 5 795\nkey c\nkey -\nkey -\ndrag handle.1 60 200\nmove 5 795");
  EXPECT_EQ(stage.screen.ui().snapshots.all().size(), 1u);
  const DisplayImage live = stage.look();
  stage.play("key tab\nmove 5 795");
  const DisplayImage flipped = stage.look();
  EXPECT_NE(pixel_at(flipped, left), pixel_at(live, left)) << "the light was elsewhere";
  stage.play("key tab\nkey w\nmove 5 795");
  const DisplayImage wiped = stage.look();
  EXPECT_EQ(pixel_at(wiped, left), pixel_at(flipped, left));
  EXPECT_EQ(pixel_at(wiped, right), pixel_at(live, right));
  stage.play("drag wipe 420 0\nmove 5 795");
  EXPECT_EQ(pixel_at(stage.look(), right), pixel_at(flipped, right));
  stage.play("key +\nkey +\nmove 5 795");
  EXPECT_NE(pixel_at(stage.look(), right), pixel_at(flipped, right))
      << "snapshots follow the exposure";
  stage.play("click snapshot.restore");
  EXPECT_EQ(stage.session.view().lights[0].position, vec3(0));
}

TEST(Offscreen, MapsOfTypeNormalAndVisibilityOfAScene) {
  Stage stage(open_spheres());
  stage.play("key p\nmove 5 795");
  std::vector<std::vector<uint8_t>> pictures{stage.session.picture().rgba};
  for (const char* key : {"t", "n", "v"}) {
    stage.play(fmt::format("key {}\nwait", key));
    EXPECT_FALSE(stage.session.status().outdated) << key;
    for (const auto& other : pictures) EXPECT_NE(stage.session.picture().rgba, other) << key;
    pictures.push_back(stage.session.picture().rgba);
  }
  stage.play("key 2\nwait");
  EXPECT_NE(stage.session.picture().rgba, pictures.back()) << "of the light that is selected";
  stage.play("key f\nkey l\nwait");
  EXPECT_NE(stage.session.picture().rgba, pictures.front());
}

TEST(Offscreen, InspectorAndHistogramAreShownOnDemand) {
  Stage stage(open_spheres());
  stage.play("key i\nkey I\nmove 480 400");
  EXPECT_TRUE(stage.screen.ui().items.find("inspector").has_value());
  EXPECT_TRUE(stage.screen.ui().items.find("histogram").has_value());
  stage.play("key i\nkey I");
  EXPECT_FALSE(stage.screen.ui().items.find("inspector").has_value());
  stage.play("key x");
  EXPECT_EQ(stage.session.view().zoom, 1);
}

TEST(Offscreen, WithoutAReferenceTheKeysAndButtonsForItDoNothing) {
  Stage stage({1280, 800}, {.reference = false});
  stage.play("key r\nkey h\nclick view.reference");
  EXPECT_EQ(stage.session.view().shown, ShownPicture::frame);
}

TEST(Offscreen, TwoRunsDrawTheSameBytes) {
  const std::string text =
      "screenshot start.png\n"
      "drag handle.1 120 40\n"
      "click view.heatmap\nscreenshot heatmap.png\n"
      "click view.reference\nkey ?\nscreenshot help.png";
  const std::filesystem::path folders[] = {fresh_folder("relume_run_a"),
                                           fresh_folder("relume_run_b")};
  for (const auto& folder : folders) {
    Workspace workspace(std::make_unique<Session>(make_fake_parts()));
    EXPECT_EQ(run_offscreen(workspace, parse_script(text, "test"), folder), 0);
  }
  for (const char* file : {"start.png", "heatmap.png", "help.png"}) {
    const std::string bytes = read_bytes(folders[0] / file);
    EXPECT_GT(bytes.size(), 1000u);
    EXPECT_EQ(bytes, read_bytes(folders[1] / file)) << file;
  }
}

TEST(Offscreen, AtZoomOneEveryPicturePixelIsAScreenPixel) {
  Stage stage;
  stage.session.view().zoom = 1;
  stage.session.view().zoom_center_px = vec2(160, 120);
  // Lights far outside, so that no handle covers the picture.
  for (Light& light : stage.session.view().lights) light.position = vec3(90, 0, 0);
  stage.play("key p\nwait");
  const DisplayImage screen = stage.look();
  const Picture& picture = stage.session.picture();
  const vec2 origin = stage.screen.ui().placement.origin;
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const ivec2 at = ivec2(origin) + ivec2(x, y);
      for (int c = 0; c < 3; ++c) {
        ASSERT_EQ(screen.pixels[3 * (static_cast<size_t>(at.y) * 1280 + at.x) + c],
                  picture.rgba[4 * (static_cast<size_t>(y) * 320 + x) + c])
            << "at " << x << ", " << y;
      }
    }
  }
}

TEST(Offscreen, SurvivesEverySizeAndComesBackTheSame) {
  Stage stage({640, 480});
  stage.play("key 1\nwait");
  const DisplayImage before = stage.look();
  stage.play("resize 1 1\nresize 2 900\nresize 900 2\nresize 4000 3\nresize 1 1");
  EXPECT_EQ(stage.surface.size_px(), ivec2(1, 1));
  stage.play("resize 640 480\nwait");
  EXPECT_EQ(stage.look().pixels, before.pixels);
}

TEST(Offscreen, LargerScaleMakesLargerControls) {
  float width[2] = {};
  for (const int scale : {1, 2}) {
    Workspace workspace(std::make_unique<Session>(make_fake_parts()));
    OsmesaSurface surface(ivec2(1280, 800) * scale);
    GlTable gl = load_gl_table(surface.loader());
    Screen screen(workspace, gl, {.scale = static_cast<float>(scale), .show_timings = false});
    play_script(parse_script("wait", "test"), workspace, screen, gl, surface, {});
    const auto rect = screen.ui().items.find("view.exposure");
    ASSERT_TRUE(rect.has_value());
    width[scale - 1] = rect->size().x;
  }
  EXPECT_NEAR(width[1] / width[0], 2, 0.05);
}

TEST(Offscreen, NamesTheStepWhoseItemDoesNotExist) {
  Stage stage;
  try {
    stage.play("wait\nclick view.nothing");
    FAIL() << "accepted";
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_NE(message.find("test:2"), std::string::npos) << message;
    EXPECT_NE(message.find("view.nothing"), std::string::npos) << message;
  }
}

TEST(Offscreen, LightsOutsideThePictureMoveAsTheCamerasTargetDoes) {
  Stage stage;
  auto& lights = stage.session.view().lights;
  const vec3 behind(1, 0, 20);
  const vec3 left(-50, 0, 0);
  lights[0].position = behind;
  lights[1].position = left;
  stage.play("wait");
  const Rect& area = stage.screen.ui().layout.picture;
  EXPECT_TRUE(area.contains(stage.center("handle.1")));
  EXPECT_GT(stage.center("handle.1").x, area.center().x);
  EXPECT_TRUE(area.contains(stage.center("handle.2")));
  EXPECT_LT(stage.center("handle.2").x, area.center().x);

  // The target is 5 in front of the eye; 240 pixels there are 2 * 5 * tan(17.5 degrees).
  const float world_per_screen =
      2 * 5 * std::tan(radians_from_degrees(17.5f)) / (240 * stage.screen.ui().placement.scale);
  stage.play("drag handle.1 50 0\ndrag handle.2 0 -50\ndrag axis.x 40 0");
  EXPECT_NEAR(glm::distance(lights[0].position, behind + vec3(50 * world_per_screen, 0, 0)), 0,
              1e-4);
  EXPECT_NEAR(glm::distance(lights[1].position, left + vec3(40, 50, 0) * world_per_screen), 0,
              1e-4);
}

TEST(Offscreen, TheListOfKeysFitsEveryWindow) {
  Stage stage;
  for (const vec2 size : {vec2(1280, 800), vec2(640, 480), vec2(500, 300)}) {
    stage.play(fmt::format("resize {} {}\nkey ?", size.x, size.y));
    const auto keys = stage.screen.ui().items.find("keys");
    ASSERT_TRUE(keys.has_value());
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(keys->min, vec2(0)))) << size.x;
    EXPECT_TRUE(glm::all(glm::lessThanEqual(keys->max, size))) << size.x;
    stage.play("key escape");
    EXPECT_FALSE(stage.screen.ui().items.find("keys").has_value());
  }
}

TEST(Offscreen, TheTradeIsChosenByNameAndByKey) {
  const auto open = [](const SessionFile&, const ProgressCallback&, PreparePreview&) {
    OpenedInput opened;
    opened.session = open_spheres();
    const Tracer& tracer = *opened.session->tracer();
    PrepareParams params;
    params.spp = 4;
    params.reduction.records = 16;
    params.width = params.height = 64;
    opened.records.forecast = [&tracer, params](const ProgressCallback& progress) {
      return forecast_scene(tracer.scene(), tracer, params, progress);
    };
    opened.records.prepare = [&tracer, params](const RecordChoice& choice, float,
                                               const ProgressCallback& progress) {
      PrepareParams chosen = params;
      chosen.budget.average_records = choice.average;
      chosen.format = choice.format;
      return make_session_records(prepare_in_memory(tracer.scene(), tracer, chosen, progress),
                                  &tracer);
    };
    return opened;
  };
  Workspace workspace(open, "spheres", {});
  workspace.wait(true);
  OsmesaSurface surface({1280, 800});
  GlTable gl = load_gl_table(surface.loader());
  Screen screen(workspace, gl, {.scale = 1, .show_timings = false});
  const auto play = [&](const std::string& text) {
    play_script(parse_script(text, "test"), workspace, screen, gl, surface, {});
  };
  const ViewState& view = workspace.session()->view();
  play("click trade.error");
  EXPECT_EQ(view.trade.kind, TradeKind::error);
  ASSERT_TRUE(workspace.trade_plan().has_value());
  EXPECT_EQ(workspace.records(), workspace.trade_plan()->records);
  EXPECT_EQ(workspace.session()->cache()->info().format, workspace.records().format);
  EXPECT_TRUE(screen.ui().items.find("trade.plan").has_value());
  play("click trade.level\ndrag trade.value -110 0");
  EXPECT_LT(view.trade.level, 0.1f);
  EXPECT_EQ(view.shadows, ShadowMethod::automatic);
  const float fewest = workspace.records().average;
  play("key >\nkey >\nkey >");
  EXPECT_GT(workspace.records().average, fewest);
  play("key <\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z\nkey ctrl+z");
  EXPECT_EQ(workspace.records().average, fewest);
  play("key ctrl+z\nkey ctrl+z\nkey ctrl+z");
  EXPECT_EQ(view.trade.kind, TradeKind::manual);
  EXPECT_FALSE(workspace.records().is_set());
}

TEST(Offscreen, SurvivesThatTheContextIsLost) {
  Stage stage;
  stage.play("key c\nkey -\nkey w\nkey ?\nmove 5 795");
  const DisplayImage before = stage.look();
  stage.play("renew-context");
  EXPECT_EQ(stage.look().pixels, before.pixels) << "picture, snapshot, panels and text";
  stage.play(
      "key ?\ndrag handle.1 60 20\nrenew-context\nresize 1 1\nrenew-context\nresize 1280 800");
  EXPECT_NE(stage.look().pixels, before.pixels);
}

/// A window of which a test says what arrives.
class ScriptedWindow final : public EventSurface {
 public:
  /// Something arrives in `events` waits, one after the other; in the `idle` that follow nothing
  /// does; then it is closed. The context is lost at frame `lost_at`.
  ScriptedWindow(int events, int idle, int lost_at = -1)
      : events_(events), idle_(idle), lost_at_(lost_at), surface_({640, 480}) {}

  GlLoader loader() const override { return surface_.loader(); }
  ivec2 size_px() const override { return surface_.size_px(); }
  void resize(ivec2 size_px) override { surface_.resize(size_px); }
  void renew_context() override {
    surface_.renew_context();
    is_lost_ = false;
    ++contexts;
  }
  void present() override {
    surface_.present();
    is_lost_ = frames == lost_at_;
    ++frames;
  }
  bool should_close() const override { return waits >= events_ + idle_; }
  bool is_context_lost() const override { return is_lost_; }
  void begin_frame() override {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(640, 480);
    io.DeltaTime = 1.0f / 60;
    io.MousePos = pointer;
  }
  bool has_pending_keys() const override { return false; }
  void poll_events() override {}
  bool wait_events(double) override {
    if (++waits > events_) return false;
    frames_at_last_event = frames;
    return true;
  }

  int frames = 0;
  int waits = 0;
  int contexts = 1;
  int frames_at_last_event = 0;
  ImVec2 pointer{5, 470};

 private:
  int events_;
  int idle_;
  int lost_at_;
  bool is_lost_ = false;
  OsmesaSurface surface_;
};

struct IdleRun {
  explicit IdleRun(ScriptedWindow& window)
      : workspace(std::make_unique<Session>(make_fake_parts())),
        gl(load_gl_table(window.loader())),
        screen(workspace, gl, {.scale = 1, .show_timings = true}) {
    ImGuiIO& io = ImGui::GetIO();
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
    workspace.wait(true);
    run_events(workspace, screen, window);
  }
  Workspace workspace;
  GlTable gl;
  Screen screen;
};

TEST(EventLoop, DrawsNothingWhileNothingHappens) {
  ScriptedWindow window(10, 500);
  const IdleRun run(window);
  EXPECT_EQ(window.waits, 510);
  EXPECT_GE(window.frames, 10);
  EXPECT_LE(window.frames - window.frames_at_last_event, 5) << "the panels settle, no more";
}

TEST(EventLoop, DrawsUntilATipIsThereAndNoLonger) {
  vec2 place(0);
  const auto run_at = [&place](vec2 pointer) {
    ScriptedWindow window(1, 200);
    window.pointer = ImVec2(pointer.x, pointer.y);
    const IdleRun run(window);
    place = run.screen.ui().items.find("view.frame")->center();
    return window.frames - window.frames_at_last_event;
  };
  const int beside = run_at({5, 470});
  const int at_a_tip = run_at(place);
  EXPECT_GT(at_a_tip, beside + 20) << "0.6 s at 60 frames a second";
  EXPECT_LT(at_a_tip, beside + 60);
}

TEST(EventLoop, GoesOnInANewContextWhenOneIsLost) {
  ScriptedWindow window(6, 3, 4);
  const IdleRun run(window);
  EXPECT_EQ(window.contexts, 2);
  EXPECT_GT(window.frames, 7);
}

TEST(LiveWindow, MemoryDoesNotGrowWithEdits) {
  const test::TemporaryFolder folder;
  Workspace workspace(open_spheres(), {}, {.state_folder = folder.path()});
  test::LiveWindow window(workspace);
  const test::SoakFigures figures =
      test::soak(window, workspace, {}, folder.path(), {.cycles = 3, .drag_moves = 6});
  EXPECT_EQ(figures.edits, 3 * test::edits_per_cycle);
  EXPECT_GT(figures.first_bytes, 1e6);
  EXPECT_LE(figures.growth(), 0.01) << figures.first_bytes << " to " << figures.last_bytes;
  EXPECT_GT(window.times().size(), 64u * 9) << "frames were drawn";
}

}  // namespace
}  // namespace relume

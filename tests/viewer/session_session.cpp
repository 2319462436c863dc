#include <gtest/gtest.h>

#include <thread>

#include "core/image/heatmap.h"
#include "tests/viewer/fake_session.h"
#include "viewer/session/light_motion.h"

namespace relume {
namespace {

std::vector<uint8_t> toned(const Image& image, const DisplayTransform& display) {
  std::vector<uint8_t> rgba(4 * image.pixel_count());
  apply_display_rgba(image, display, rgba);
  return rgba;
}

Image render(FrameSource& source, const ViewState& view) {
  RelitFrame frame;
  source.render({view.lights, view.shadows}, false, frame);
  return frame.image;
}

TEST(Session, PaintsTheFrameOfItsLights) {
  Session session(make_fake_parts());
  EXPECT_EQ(session.picture().version, 0u);
  EXPECT_TRUE(session.picture().rgba.empty());
  session.wait(true);
  SessionParts same = make_fake_parts();
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));

  const uint64_t version = session.picture().version;
  session.wait(true);
  EXPECT_EQ(session.picture().version, version) << "repainted without a change";

  session.view().lights[0].position.x = 0.4f;
  session.view().lights[1].mute = true;
  session.view().display.exposure = -1;
  session.wait(true);
  EXPECT_GT(session.picture().version, version);
  EXPECT_EQ(session.picture().rgba,
            toned(render(*same.frames, session.view()), session.view().display));
  EXPECT_FALSE(session.status().outdated);
  EXPECT_FALSE(session.status().busy);
}

TEST(Session, ChangesOfShadowsReachTheFrame) {
  Session session(make_fake_parts());
  session.wait(true);
  const std::vector<uint8_t> before = session.picture().rgba;
  session.view().shadows = ShadowMethod::none;
  session.wait(true);
  SessionParts same = make_fake_parts();
  EXPECT_NE(session.picture().rgba, before);
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));
}

TEST(Session, ShowsTheReferenceOnlyWhenTheLightRests) {
  Session session(make_fake_parts());
  session.view().shown = ShownPicture::reference;
  session.wait(false);
  EXPECT_EQ(session.status().painted, ShownPicture::frame);
  EXPECT_TRUE(session.status().outdated);
  session.wait(true);
  EXPECT_EQ(session.status().painted, ShownPicture::reference);
  EXPECT_FALSE(session.status().outdated);
  SessionParts same = make_fake_parts();
  EXPECT_EQ(session.picture().rgba, toned(render(*same.reference, session.view()), {}));

  session.view().lights[0].position.y = 0.3f;
  session.wait(false);
  EXPECT_EQ(session.status().painted, ShownPicture::frame) << "a moving light shows the frame";
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));
}

TEST(Session, ReferenceHasTracedShadowsWhateverTheFrameHas) {
  Session session(make_fake_parts());
  session.view().shown = ShownPicture::reference;
  session.wait(true);
  const std::vector<uint8_t> traced = session.picture().rgba;
  session.view().shadows = ShadowMethod::none;
  session.wait(true);
  EXPECT_EQ(session.picture().rgba, traced);
}

TEST(Session, HeatmapMeasuresFrameAgainstReference) {
  Session session(make_fake_parts());
  session.view().shown = ShownPicture::heatmap;
  session.wait(true);
  ASSERT_TRUE(session.status().error.has_value());
  SessionParts same = make_fake_parts();
  const ImageError expected =
      compare_images(render(*same.frames, session.view()), render(*same.reference, session.view()));
  EXPECT_DOUBLE_EQ(session.status().error->error_image, expected.error_image);
  EXPECT_GT(expected.error_image, 0);
  EXPECT_FLOAT_EQ(session.status().heat_range, 0.1f);
  EXPECT_EQ(session.picture().rgba.size(), 4u * 320 * 240);

  const std::vector<uint8_t> ten_times = session.picture().rgba;
  session.view().lights[0].gain = 5;
  session.wait(false);
  EXPECT_EQ(session.picture().rgba, ten_times) << "the last heatmap stays while a light moves";
  EXPECT_TRUE(session.status().outdated);
  session.wait(true);
  EXPECT_FALSE(session.status().outdated);
  EXPECT_NE(session.picture().rgba, ten_times);
}

TEST(Session, HeatmapOfEqualPicturesIsBlack) {
  SessionParts parts = make_fake_parts();
  parts.reference = std::move(make_fake_parts().frames);
  Session session(std::move(parts));
  session.view().shown = ShownPicture::heatmap;
  session.view().heat_range = HeatRange::automatic;
  session.wait(true);
  ASSERT_TRUE(session.status().error.has_value());
  EXPECT_EQ(session.status().error->error_image, 0);
  const std::vector<uint8_t>& rgba = session.picture().rgba;
  for (size_t i = 4; i < rgba.size(); ++i) ASSERT_EQ(rgba[i], rgba[i - 4]) << "at byte " << i;
}

TEST(Session, WithoutAReferenceItKeepsShowingTheFrame) {
  Session session(make_fake_parts({.reference = false}));
  EXPECT_FALSE(session.info().has_reference);
  session.view().shown = ShownPicture::heatmap;
  session.wait(true);
  EXPECT_EQ(session.status().painted, ShownPicture::frame);
  EXPECT_TRUE(session.status().outdated);
}

/// The colour of a pixel of the painted picture.
std::array<int, 3> painted_color(const Session& session, int x, int y) {
  const Picture& picture = session.picture();
  const size_t i = 4 * (static_cast<size_t>(y) * picture.width + x);
  return {picture.rgba.at(i), picture.rgba.at(i + 1), picture.rgba.at(i + 2)};
}

void expect_heat(const std::array<int, 3>& color, float value) {
  const vec3 expected = 255.0f * heat_color(value);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], expected[c], 2.5) << "channel " << c;
}

TEST(Session, PredictedErrorHasTheScaleOfTheHeatmap) {
  Session session(make_fake_parts());
  session.view().shown = ShownPicture::predicted;
  session.wait(true);
  EXPECT_EQ(session.status().painted, ShownPicture::predicted);
  EXPECT_FALSE(session.status().outdated);
  EXPECT_FLOAT_EQ(session.status().heat_range, 0.1f);
  ASSERT_TRUE(session.status().map_mean.has_value());
  EXPECT_NEAR(*session.status().map_mean, 0.1 * 239 / 240, 1e-6);
  expect_heat(painted_color(session, 7, 60), 0.5f);
  expect_heat(painted_color(session, 300, 180), 1);
  session.view().heat_range = HeatRange::automatic;
  session.wait(true);
  EXPECT_FLOAT_EQ(session.status().heat_range, 0.2f);
  expect_heat(painted_color(session, 300, 180), 0.75f);
}

TEST(Session, RecordMapEndsAtSixteenOrTheRecordsAskedFor) {
  Session session(make_fake_parts());
  session.view().shown = ShownPicture::records;
  session.wait(true);
  EXPECT_EQ(session.status().painted, ShownPicture::records);
  EXPECT_FLOAT_EQ(session.status().heat_range, 16);
  EXPECT_NEAR(session.status().map_mean.value_or(0), 9.5, 1e-6);
  expect_heat(painted_color(session, 8 * 16, 50), 0.5f);
  expect_heat(painted_color(session, 19 * 16, 50), 1);
  SessionParts many = make_fake_parts();
  many.info.records = 32;
  Session wide(std::move(many));
  wide.view().shown = ShownPicture::records;
  wide.wait(true);
  EXPECT_FLOAT_EQ(wide.status().heat_range, 32);
  expect_heat(painted_color(wide, 8 * 16, 50), 0.25f);
}

TEST(Session, MapsAreNotRepaintedWhenALightMovesNorNeedTheReference) {
  Session session(make_fake_parts({.reference = false}));
  for (const ShownPicture map : {ShownPicture::predicted, ShownPicture::records}) {
    session.view().shown = map;
    session.wait(true);
    const uint64_t version = session.picture().version;
    session.view().lights[0].position.x += 0.4f;
    session.wait(false);
    EXPECT_EQ(session.status().painted, map);
    EXPECT_FALSE(session.status().outdated);
    EXPECT_EQ(session.picture().version, version);
  }
  session.view().shown = ShownPicture::frame;
  session.wait(true);
  EXPECT_EQ(session.status().heat_range, 0);
  EXPECT_FALSE(session.status().map_mean.has_value());
  SessionParts same = make_fake_parts();
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));
}

TEST(Session, WithoutPredictedErrorItKeepsShowingTheFrame) {
  Session session(make_fake_parts({.predicted_error = false}));
  session.view().shown = ShownPicture::predicted;
  session.wait(true);
  EXPECT_EQ(session.status().painted, ShownPicture::frame);
  SessionParts same = make_fake_parts();
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));
}

TEST(Session, ReportsALightThatCannotBeUsedAndKeepsThePicture) {
  Session session(make_fake_parts());
  session.wait(true);
  const Picture before = session.picture();
  session.view().lights[1].position.x = std::numeric_limits<float>::quiet_NaN();
  session.wait(true);
  EXPECT_NE(session.status().problem.find("light 2"), std::string::npos)
      << session.status().problem;
  EXPECT_EQ(session.picture().version, before.version);
  session.view().lights[1].position.x = 0;
  session.wait(true);
  EXPECT_EQ(session.status().problem, "");
  EXPECT_NE(session.picture().rgba, before.rgba);
}

/// Takes 1 ms for each record of its share of the pixels; notes what it was asked for.
class CountingSource final : public FrameSource {
 public:
  explicit CountingSource(std::vector<RelightRequest>& requests) : requests_(requests) {}
  void render(const RelightRequest& request, const std::atomic<bool>&, RelitFrame& frame) override {
    requests_.push_back(request);
    const double records = 40 * share_cost(request.pixels);
    std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(records));
    frame.image = Image(320, 240);
    frame.stats.layers_shaded = 2;
    frame.work = {records, 1, 2, 2};
  }

 private:
  std::vector<RelightRequest>& requests_;  ///< read when the session rests
};

class ProgressiveSession : public testing::Test {
 protected:
  ProgressiveSession() : session_(make_parts()) { session_.view().shown = ShownPicture::frame; }
  std::vector<PixelShare> shares(bool resting) {
    requests_.clear();
    session_.wait(resting);
    std::vector<PixelShare> shares;
    for (const RelightRequest& request : requests_) shares.push_back(request.pixels);
    return shares;
  }
  void move_light() { session_.view().lights[0].position.x += 0.1f; }

  std::vector<RelightRequest> requests_;
  Session session_;

 private:
  SessionParts make_parts() {
    SessionParts parts = make_fake_parts();
    parts.frames = std::make_unique<CountingSource>(requests_);
    return parts;
  }
};

using Shares = std::vector<PixelShare>;

TEST_F(ProgressiveSession, StartsCoarseWhereNothingIsKnown) {
  session_.view().frame_ms = 10;
  EXPECT_EQ(shares(true), (Shares{PixelShare::quarter, PixelShare::all}));
  EXPECT_FALSE(session_.status().outdated);
  EXPECT_EQ(session_.status().pixels, PixelShare::all);
}

TEST_F(ProgressiveSession, IsCoarseFirstOnlyAboveTheTime) {
  session_.view().frame_ms = 10;
  shares(true);
  move_light();
  EXPECT_EQ(shares(true), (Shares{PixelShare::quarter, PixelShare::all}));
  EXPECT_TRUE(requests_[1].may_stop);
  EXPECT_FALSE(requests_[0].may_stop) << "a coarse frame is always finished";
  session_.view().frame_ms = 1000;
  move_light();
  EXPECT_EQ(shares(true), (Shares{PixelShare::all}));
  session_.view().frame_ms = 0;
  move_light();
  EXPECT_EQ(shares(true), (Shares{PixelShare::all}));
}

TEST_F(ProgressiveSession, SumsInOrderAtRest) {
  session_.view().frame_ms = 0;
  shares(true);
  move_light();
  shares(false);
  ASSERT_EQ(requests_.size(), 1u);
  EXPECT_TRUE(requests_[0].dragging);
  shares(true);
  ASSERT_EQ(requests_.size(), 1u);
  EXPECT_FALSE(requests_[0].dragging);
  EXPECT_TRUE(shares(true).empty());
}

TEST(Session, RefinesTheFrameAtRest) {
  Session session(make_fake_parts());
  session.view().refine = true;
  session.wait(false);
  EXPECT_FALSE(session.status().refined);
  session.wait(true);
  EXPECT_TRUE(session.status().refined);
  EXPECT_FALSE(session.status().outdated);
  SessionParts same = make_fake_parts();
  EXPECT_EQ(session.picture().rgba, toned(render(*same.reference, session.view()), {}));
  // A light that moves shows the records again; a gain the same.
  session.view().lights[0].gain *= 2;
  session.wait(false);
  EXPECT_FALSE(session.status().refined);
  EXPECT_EQ(session.picture().rgba, toned(render(*same.frames, session.view()), {}));
  // Traced shadows do not replace none.
  session.view().shadows = ShadowMethod::none;
  session.wait(true);
  EXPECT_FALSE(session.status().refined);
}

TEST(LightMotion, ViewPlaneMoveFollowsThePointerAtConstantDepth) {
  Camera camera;
  camera.eye = vec3(3, 2, 5);
  camera.target = vec3(0.5f, 0.25f, -1);
  const CameraRays rays(camera, 640, 360);
  for (const vec3 p : {vec3(0), vec3(1, 1, 1), vec3(-3, 2, -4)}) {
    const auto from = rays.project(p);
    for (const vec2 delta : {vec2(40, 0), vec2(0, -70), vec2(-123, 45)}) {
      const auto to = rays.project(move_in_view_plane(rays, p, delta));
      EXPECT_NEAR(to.film_px.x - from.film_px.x, delta.x, 1e-2);
      EXPECT_NEAR(to.film_px.y - from.film_px.y, delta.y, 1e-2);
      EXPECT_NEAR(to.depth, from.depth, 1e-4);
    }
  }
}

TEST(LightMotion, NothingMovesBehindTheEyeOrAlongTheLineOfSight) {
  const CameraRays rays(Camera{}, 640, 360);
  const vec3 behind(0, 0, 7);
  EXPECT_EQ(move_in_view_plane(rays, behind, vec2(10)), behind);
  EXPECT_EQ(move_along_axis(rays, behind, vec3(1, 0, 0), 1, vec2(10)), behind);
  const vec3 ahead(0, 0, 0);
  EXPECT_EQ(move_along_axis(rays, ahead, vec3(0, 0, 1), 1, vec2(10)), ahead);
}

TEST(LightMotion, AxisMoveStaysOnTheAxisAndFollowsThePointer) {
  const CameraRays rays(Camera{}, 640, 360);
  const vec3 p(0.5f, -0.25f, 0);
  const vec3 moved = move_along_axis(rays, p, vec3(1, 0, 0), 0.5f, vec2(30, 12));
  EXPECT_EQ(moved.y, p.y);
  EXPECT_EQ(moved.z, p.z);
  EXPECT_NEAR(rays.project(moved).film_px.x - rays.project(p).film_px.x, 30, 1e-2);
}

TEST(LightMotion, DirectionalLightTurnsWhenItsHandleMoves) {
  Bounds bounds;
  bounds.extend(vec3(-2));
  bounds.extend(vec3(2));
  Light light;
  light.type = LightType::directional;
  light.direction = vec3(0, -5, 0);
  const vec3 handle = light_handle(light, bounds);
  EXPECT_NEAR(glm::distance(handle, vec3(0, bounds.radius(), 0)), 0, 1e-5);
  set_light_handle(light, bounds, vec3(3, 0, 0));
  EXPECT_NEAR(glm::distance(light.direction, vec3(-1, 0, 0)), 0, 1e-6);
  const Light before = light;
  set_light_handle(light, bounds, bounds.center());
  EXPECT_EQ(light.direction, before.direction);
  set_light_handle(light, bounds, vec3(std::numeric_limits<float>::infinity()));
  EXPECT_EQ(light.direction, before.direction);
}

}  // namespace
}  // namespace relume

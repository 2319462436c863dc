#include <gtest/gtest.h>

#include "shadow/automatic.h"
#include "shadow/shadow.h"
#include "tests/support/records.h"
#include "tests/support/scenes.h"

namespace relume {
namespace {

using namespace test;  // NOLINT: scene and light builders

/// A method whose moves take as long as a script says.
class TimedSource final : public VisibilitySource {
 public:
  TimedSource(double& clock_ms, double move_ms) : clock_ms_(clock_ms), move_ms_(move_ms) {}
  void prepare(const Light&) override { clock_ms_ += move_ms_; }
  void visibility(const Receivers&, float*) const override {}
  uint64_t memory_bytes() const override { return 1; }

 private:
  double& clock_ms_;
  double move_ms_;
};

/// AutomaticVisibility over such methods.
class ScriptedShadows {
 public:
  explicit ScriptedShadows(const ShadowContent& content, std::map<ShadowMethod, double> move_ms)
      : source(
            content,
            [this, move_ms = std::move(move_ms)](ShadowMethod method) {
              made.push_back(method);
              clock_ms += 1000;  // making a structure does not count
              return std::make_unique<TimedSource>(clock_ms, move_ms.at(method));
            },
            [this] { return clock_ms; }) {}

  ShadowMethod move(ShadowLevel level, double budget_ms) {
    source.set_goal(level, budget_ms);
    source.prepare(Light());
    source.end_move();
    return source.choice().method;
  }

  double clock_ms = 0;
  std::vector<ShadowMethod> made;
  AutomaticVisibility source;
};

constexpr ShadowContent thin{true, true};
constexpr ShadowContent solids{false, true};

TEST(AutomaticVisibility, TracesSolidsAndBuildsNothingElse) {
  ScriptedShadows shadows(solids, {{ShadowMethod::ray, 500}, {ShadowMethod::members, 900}});
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 10), ShadowMethod::ray);
  EXPECT_EQ(shadows.move(ShadowLevel::rest, 10), ShadowMethod::ray);
  EXPECT_EQ(shadows.source.choice().reason, "ray: solids only");
  EXPECT_EQ(shadows.made, std::vector<ShadowMethod>{ShadowMethod::ray});
  EXPECT_EQ(shadows.move(ShadowLevel::final, 10), ShadowMethod::members);
}

TEST(AutomaticVisibility, TracesAllMembersAtTheEnd) {
  ScriptedShadows shadows(thin, {{ShadowMethod::members, 900}});
  EXPECT_EQ(shadows.move(ShadowLevel::final, 1), ShadowMethod::members);
  ScriptedShadows without({true, false}, {{ShadowMethod::ray, 900}});
  EXPECT_EQ(without.move(ShadowLevel::final, 1), ShadowMethod::ray);
}

TEST(AutomaticVisibility, StartsWithTheCheapestAndGrowsIntoTheBudget) {
  ScriptedShadows shadows(
      thin,
      {{ShadowMethod::volume, 5}, {ShadowMethod::opacity, 12}, {ShadowMethod::coverage, 300}});
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::volume);
  EXPECT_EQ(shadows.source.choice().reason, "volume: nothing timed yet");
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::opacity) << "15 ms expected";
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::opacity);
  EXPECT_EQ(shadows.source.choice().reason, "opacity: 12 of 33 ms");
  EXPECT_EQ(shadows.move(ShadowLevel::rest, 400), ShadowMethod::coverage);
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 400), ShadowMethod::coverage);
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::opacity);
  EXPECT_EQ(shadows.source.memory_bytes(), 3u);
}

TEST(AutomaticVisibility, LeavesWhatTurnsOutTooSlow) {
  // Opacity takes 20 times volume's time instead of 3: it is tried once.
  ScriptedShadows shadows(thin, {{ShadowMethod::volume, 5}, {ShadowMethod::opacity, 100}});
  shadows.move(ShadowLevel::drag, 33);
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::opacity);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::volume);
  }
  EXPECT_EQ(shadows.source.choice().reason, "volume: 5 of 33 ms");
}

TEST(AutomaticVisibility, TakesTheCheapestWhereNothingFits) {
  ScriptedShadows shadows(thin, {{ShadowMethod::volume, 50}});
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::volume);
  }
}

TEST(AutomaticVisibility, StaysWithAMethodNearTheBudget) {
  // 30 ms fit 33 ms for a method in use; one that is not in use must fit 26 ms.
  ScriptedShadows shadows(thin, {{ShadowMethod::volume, 5}, {ShadowMethod::opacity, 30}});
  shadows.move(ShadowLevel::drag, 33);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::opacity);
  }
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 20), ShadowMethod::volume);
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 33), ShadowMethod::volume);
  EXPECT_EQ(shadows.move(ShadowLevel::drag, 40), ShadowMethod::opacity);
}

TEST(AutomaticVisibility, AnswersAsTheMethodItPicked) {
  // The shadow of a strand and a quad on a plane, at each level.
  Scene scene = make_plane_scene(2, vec3(0.5f), 32, 32);
  add_shape(scene, make_quad({0.5f, 0, 0.4f}, {0.4f, 0, 0}, {0, 0.4f, 0}, 0));
  const uint32_t hair = add_material(scene, "kajiya-kay");
  add_shape(scene, make_strand({-1, 0, 0.5f}, {0.2f, 0, 0.5f}, 0.05f, 3, hair));
  const Tracer tracer(scene);
  const RelightCache cache = make_full_cache(scene, tracer, 4);
  const auto source = make_shadow(ShadowMethod::automatic, tracer, cache);
  auto& automatic = dynamic_cast<AutomaticVisibility&>(*source);
  const Light light = make_point_light({0, 0, 3});
  for (const ShadowLevel level : {ShadowLevel::drag, ShadowLevel::rest, ShadowLevel::final}) {
    automatic.set_goal(level, 1e6);
    source->prepare(light);
    const auto other = make_shadow(automatic.choice().method, tracer, cache);
    other->prepare(light);
    const Image expected = render_frame(cache, {&light, 1}, other.get());
    EXPECT_EQ(max_difference(render_frame(cache, {&light, 1}, source.get()), expected), 0)
        << label_of(shadow_level_labels, level);
    automatic.end_move();
  }
  EXPECT_EQ(automatic.choice().method, ShadowMethod::ray) << "no members are kept";
}

}  // namespace
}  // namespace relume

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/scene/io/load_scene.h"
#include "core/shade/shaders.h"
#include "tests/support/temporary_folder.h"
#include "tests/viewer/fake_session.h"
#include "viewer/session/prepare.h"
#include "viewer/session/trade.h"
#include "viewer/session/workspace.h"

namespace relume {
namespace {

using test::TemporaryFolder;

/// Pixels whose error halves with each record, and formats that take 1, 0.7 and 0.6 ms a record.
FrameForecast make_forecast() {
  FrameForecast forecast;
  forecast.formats = {{CacheFormat::exact, 0, 1, 1},
                      {CacheFormat::standard, 0.001, 1, 0.7},
                      {CacheFormat::compact, 0.004, 1, 0.6}};
  for (int pixel = 0; pixel < 200; ++pixel) {
    ErrorCurve curve;
    curve.value = 1;
    float error = 0.2f + 0.001f * static_cast<float>(pixel);
    for (int k = 0; k <= 12; ++k, error *= 0.5f) {
      curve.errors.push_back(error);
      curve.records.push_back(record_steps[static_cast<size_t>(k)]);
    }
    forecast.curves.push_back(curve);
  }
  return forecast;
}

TradePlan plan_at(float level) {
  return plan_trade({.kind = TradeKind::level, .level = level}, make_forecast(), true);
}

TEST(Trade, ALevelBuysLessErrorWithMoreTime) {
  TradePlan before = plan_at(0);
  EXPECT_EQ(before.records.average, 1);
  for (const float level : {0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
    const TradePlan plan = plan_at(level);
    EXPECT_GT(plan.records.average, before.records.average) << level;
    EXPECT_LT(plan.error, before.error) << level;
    EXPECT_GT(plan.move_ms, before.move_ms) << level;
    before = plan;
  }
  EXPECT_EQ(before.records, (RecordChoice{8, CacheFormat::exact}));
}

TEST(Trade, AFormatIsTakenWhereItHardlyAddsToTheError) {
  EXPECT_EQ(plan_at(0).records.format, CacheFormat::compact) << "0.004 beside 0.15";
  EXPECT_EQ(plan_at(0.9f).records.format, CacheFormat::standard) << "0.004 beside 0.003";
}

TEST(Trade, ATimeIsKeptAndLeavesHalfToShadows) {
  const FrameForecast forecast = make_forecast();
  const auto plan = [&](float ms, bool has_shadows) {
    return plan_trade({.kind = TradeKind::time, .move_ms = ms}, forecast, has_shadows);
  };
  EXPECT_LE(plan(4, false).move_ms, 4);
  EXPECT_LE(plan(8, true).move_ms, 4);
  EXPECT_EQ(plan(8, true).records, plan(4, false).records);
  EXPECT_TRUE(plan(4, false).is_met);
  EXPECT_FALSE(plan(0.5f, false).is_met);
}

TEST(Trade, AnErrorIsKeptWithTwoDigits) {
  const TradePlan plan =
      plan_trade({.kind = TradeKind::error, .target_error = 0.02f}, make_forecast(), true);
  EXPECT_LE(plan.error, 0.02);
  EXPECT_GT(plan.error, 0.015);
  const float tenths = 10 * plan.records.average;
  EXPECT_NEAR(tenths, std::round(tenths), 1e-4);
  EXPECT_FALSE(
      plan_trade({.kind = TradeKind::error, .target_error = 1e-5f}, make_forecast(), true).is_met);
}

TEST(Trade, WritesTheSettingsBelowIt) {
  ViewState view;
  view.trade = {.kind = TradeKind::level, .level = 0};
  apply_trade(view);
  EXPECT_EQ(view.shadows, ShadowMethod::automatic);
  EXPECT_FALSE(view.refine);
  const float fast_ms = view.frame_ms;
  view.trade.level = 1;
  apply_trade(view);
  EXPECT_TRUE(view.refine);
  EXPECT_GT(view.frame_ms, fast_ms);
  view.shadows = ShadowMethod::none;
  view.trade = {.kind = TradeKind::time, .move_ms = 7};
  apply_trade(view);
  EXPECT_EQ(view.shadows, ShadowMethod::none) << "stay off";
  EXPECT_EQ(view.frame_ms, 7);
  const ViewState before = view;
  view.trade.kind = TradeKind::manual;
  apply_trade(view);
  EXPECT_EQ(view.frame_ms, before.frame_ms);
}

/// Records of a fake session; `prepared` notes what was asked for.
OpenedInput open_fake(std::vector<RecordChoice>& prepared) {
  OpenedInput opened;
  opened.session = std::make_unique<Session>(make_fake_parts());
  opened.records.forecast = [](const ProgressCallback&) { return make_forecast(); };
  opened.records.prepare = [&prepared](const RecordChoice& choice, float,
                                       const ProgressCallback& progress) {
    if (choice.average > 7.9f) throw Error(ErrorKind::limit, "too many records");
    if (!progress("prepare", 0.5, 1)) throw Error(ErrorKind::cancelled, "stopped");
    prepared.push_back(choice);
    SessionParts parts = make_fake_parts();
    parts.info.budget.average_records = choice.average;
    parts.info.format = choice.format;
    return SessionRecords{std::move(parts.info), std::move(parts.frames), nullptr};
  };
  return opened;
}

struct Desk {
  explicit Desk(const std::filesystem::path& state, const std::string& input = "hair")
      : workspace([this](const SessionFile&, const ProgressCallback&,
                         PreparePreview&) { return open_fake(prepared); },
                  input, {.state_folder = state, .work_folder = state}) {
    workspace.wait(true);
  }
  ViewState& view() { return workspace.session()->view(); }
  void set_level(float level) {
    view().trade = {.kind = TradeKind::level, .level = level};
    apply_trade(view());
  }
  std::vector<RecordChoice> prepared;
  Workspace workspace;
};

TEST(Trade, RecordsAreReplacedBehindThePicture) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  const Session* session = desk.workspace.session();
  const std::vector<uint8_t> picture = session->picture().rgba;
  desk.set_level(0.5f);
  desk.workspace.wait(true);
  ASSERT_EQ(desk.prepared.size(), 1u);
  EXPECT_EQ(desk.workspace.session(), session) << "the same session goes on";
  EXPECT_EQ(desk.workspace.records(), desk.prepared[0]);
  EXPECT_EQ(session->info().budget.average_records, desk.prepared[0].average);
  EXPECT_EQ(session->view().records, desk.prepared[0]);
  EXPECT_TRUE(session->info().has_reference) << "is kept";
  EXPECT_FALSE(session->status().busy);
  EXPECT_EQ(session->picture().rgba.size(), picture.size());
}

TEST(Trade, NothingIsPreparedWhileTheSliderIsDragged) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  desk.set_level(0.5f);
  desk.workspace.wait(true);
  for (const float level : {0.6f, 0.7f, 0.8f}) {
    desk.set_level(level);
    desk.workspace.wait(false);
    EXPECT_EQ(desk.workspace.trade_plan()->records, plan_at(level).records) << "is told";
  }
  EXPECT_EQ(desk.prepared.size(), 1u);
  desk.workspace.wait(true);
  ASSERT_EQ(desk.prepared.size(), 2u);
  EXPECT_EQ(desk.prepared[1], plan_at(0.8f).records);
}

TEST(Trade, IsOneStepOfTheHistoryAndBringsRecordsBack) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  desk.set_level(0.3f);
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.history().step_count(), 1u) << "the records are none of their own";
  desk.set_level(0.7f);
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.history().step_count(), 2u);
  desk.workspace.undo();
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.records(), plan_at(0.3f).records);
  desk.workspace.undo();
  desk.workspace.wait(true);
  EXPECT_FALSE(desk.workspace.records().is_set()) << "as opened";
  EXPECT_EQ(desk.view().shadows, ShadowMethod::ray);
  desk.workspace.redo();
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.records(), plan_at(0.3f).records);
}

TEST(Trade, WhatCannotBePreparedIsANoticeOnce) {
  const TemporaryFolder folder;
  Desk desk(folder.path());
  desk.set_level(1);
  desk.workspace.wait(true);
  EXPECT_TRUE(desk.workspace.notice().is_problem);
  EXPECT_FALSE(desk.workspace.records().is_set());
  EXPECT_GT(desk.workspace.session()->picture().version, 0u) << "what was there goes on";
  desk.set_level(0.4f);
  desk.workspace.wait(true);
  EXPECT_EQ(desk.workspace.records(), plan_at(0.4f).records);
}

TEST(Trade, AViewThatCannotBeMeasuredIsANoticeAndNoMore) {
  const TemporaryFolder folder;
  int asked = 0;
  const auto opener = [&](const SessionFile&, const ProgressCallback&, PreparePreview&) {
    OpenedInput opened;
    opened.session = std::make_unique<Session>(make_fake_parts());
    opened.records.forecast = [&asked](const ProgressCallback&) -> FrameForecast {
      ++asked;
      throw Error(ErrorKind::limit, "cannot be measured");
    };
    opened.records.prepare = [](const RecordChoice&, float,
                                const ProgressCallback&) -> SessionRecords { return {}; };
    return opened;
  };
  Workspace workspace(opener, "hair", {.state_folder = folder.path()});
  workspace.wait(true);
  workspace.session()->view().trade.kind = TradeKind::level;
  for (int i = 0; i < 3; ++i) workspace.wait(true);
  EXPECT_EQ(asked, 1);
  EXPECT_NE(workspace.notice().text.find("cannot be measured"), std::string::npos);
  EXPECT_FALSE(workspace.trade_plan().has_value());
}

TEST(Trade, ASavedSessionKeepsItsRecords) {
  const TemporaryFolder folder;
  RecordChoice chosen;
  {
    Desk desk(folder.path());
    desk.set_level(0.5f);
    desk.workspace.wait(true);
    chosen = desk.workspace.records();
    ASSERT_TRUE(desk.workspace.save(folder.file("mine.json")));
  }
  // The input has its own records: those of the session are prepared without a plan.
  Desk desk(folder.path(), folder.file("mine.json").string());
  EXPECT_EQ(desk.view().trade, (Trade{.kind = TradeKind::level, .level = 0.5f}));
  EXPECT_EQ(desk.workspace.records(), chosen);
  EXPECT_EQ(desk.prepared, std::vector<RecordChoice>{chosen});
}

TEST(Trade, ClosesWhileRecordsArePrepared) {
  const TemporaryFolder folder;
  std::atomic<bool> started{false};
  std::atomic<bool> cancelled{false};
  const auto opener = [&](const SessionFile&, const ProgressCallback&, PreparePreview&) {
    OpenedInput opened;
    opened.session = std::make_unique<Session>(make_fake_parts({.reference = false}));
    opened.records.forecast = [](const ProgressCallback&) { return make_forecast(); };
    opened.records.prepare = [&](const RecordChoice&, float,
                                 const ProgressCallback& progress) -> SessionRecords {
      started = true;
      while (progress("stuck", 0.5, 1)) std::this_thread::yield();
      cancelled = true;
      throw Error(ErrorKind::cancelled, "stopped");
    };
    return opened;
  };
  {
    Workspace workspace(opener, "hair", {.state_folder = folder.path()});
    workspace.wait(true);
    workspace.session()->view().trade.kind = TradeKind::level;
    while (!started) workspace.update(true);
    EXPECT_FALSE(cancelled);
  }
  EXPECT_TRUE(cancelled) << "it waited for the preparation to give up";
}

TEST(Trade, RecordsOfAForecastAreThoseOfItsBudget) {
  const Scene scene = load_scene("spheres", shader_table());
  const Tracer tracer(scene);
  PrepareParams params;
  params.spp = 4;
  params.reduction.records = 16;
  params.width = params.height = 64;
  const FrameForecast forecast = forecast_scene(scene, tracer, params, {});
  const TradePlan plan = plan_trade({.kind = TradeKind::level, .level = 0.25f}, forecast, true);
  params.budget = {.average_records = plan.records.average};
  params.format = plan.records.format;
  const RelightCache asked = prepare_in_memory(scene, tracer, params, {});
  params.record_cost = plan.record_cost;
  const RelightCache planned = prepare_in_memory(scene, tracer, params, {});
  EXPECT_EQ(asked.info().record_count, planned.info().record_count);
  EXPECT_EQ(asked.record_counts(), planned.record_counts());
  EXPECT_EQ(asked.predicted_error(), planned.predicted_error());
  EXPECT_GT(planned.info().record_count, 0u);
}

}  // namespace
}  // namespace relume

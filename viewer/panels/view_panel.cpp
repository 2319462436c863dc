#include "viewer/panels/view_panel.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/image/heatmap.h"
#include "viewer/panels/widgets.h"
#include "viewer/session/false_color.h"
#include "viewer/session/pixel_maps.h"

namespace relume {
namespace {

constexpr float largest_exposure = 10;
constexpr float largest_frame_ms = 1000;

std::string short_count(uint64_t count) {
  const double value = static_cast<double>(count);
  if (value >= 1e6) return fmt::format("{:.2f} M", value * 1e-6);
  if (value >= 1e4) return fmt::format("{:.1f} k", value * 1e-3);
  return fmt::format("{}", count);
}

std::string records_text(const SessionInfo& info) {
  if (info.budget.average_records > 0)
    return fmt::format("average {:g}", info.budget.average_records);
  if (info.budget.target_error > 0)
    return fmt::format("error {:g} %", 100 * info.budget.target_error);
  return fmt::format("k = {}", info.records);
}

std::string scene_line(const Session& session) {
  const SessionInfo& info = session.info();
  return fmt::format("{}x{}   {}, {}   {} records   {} lights", info.width, info.height,
                     info.method, records_text(info), short_count(info.record_count),
                     session.view().lights.size());
}

std::string work_line(const UiState& ui, const Session& session) {
  const SessionStatus& status = session.status();
  std::string line;
  if (status.error) {
    line = fmt::format("error {:.5f} on covered pixels, {:.5f} on all   ",
                       status.error->error_covered, status.error->error_image);
  }
  if (status.map_mean) {
    line = fmt::format("mean {:.5g} on covered pixels   ", *status.map_mean);
  }
  if (session.info().predicted_mean > 0 && !status.error) {
    line += fmt::format("expected error {:.4f}   ", session.info().predicted_mean);
  }
  if (session.picture().version == 0) return line + "relighting...";
  if (!ui.show_timings) return line;
  line += fmt::format("{} light{} relit in {:.1f} ms", status.stats.layers_shaded,
                      status.stats.layers_shaded == 1 ? "" : "s", status.frame_ms);
  return status.shadows_used.empty() ? line : line + "   shadows " + status.shadows_used;
}

const char* heat_unit(ShownPicture shown) {
  switch (shown) {
    case ShownPicture::heatmap:
      return "RMS error";
    case ShownPicture::predicted:
      return "predicted RMS error";
    case ShownPicture::records:
      return "records";
    case ShownPicture::visibility:
      return "visible share";
    case ShownPicture::frame:
    case ShownPicture::reference:
    case ShownPicture::difference:
    case ShownPicture::type:
    case ShownPicture::normal:
      break;
  }
  return "";
}

void heat_scale(const UiState& ui, const char* unit, float range) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float font = ImGui::GetFontSize();
  const vec2 size(14 * font, 0.7f * font);
  const vec2 low = vec2(ui.layout.picture.min.x, ui.layout.picture.max.y) + vec2(1, -2.6f) * font;
  constexpr int steps = 64;
  for (int i = 0; i < steps; ++i) {
    const vec3 color = heat_color((static_cast<float>(i) + 0.5f) / steps);
    const float left = std::round(low.x + size.x * static_cast<float>(i) / steps);
    const float right = std::round(low.x + size.x * static_cast<float>(i + 1) / steps);
    list.AddRectFilled({left, low.y}, {right, low.y + size.y},
                       ImGui::ColorConvertFloat4ToU32({color.x, color.y, color.z, 1}));
  }
  list.AddRect(to_im(low), to_im(low + size), IM_COL32(200, 200, 200, 255));
  const float text_y = low.y + size.y + 0.1f * font;
  const std::string top = fmt::format("{:g}", range);
  add_outlined_text(list, {low.x, text_y}, IM_COL32_WHITE, "0");
  const float unit_width = ImGui::CalcTextSize(unit).x;
  add_outlined_text(list, {low.x + 0.5f * (size.x - unit_width), text_y}, IM_COL32_WHITE, unit);
  const float top_width = ImGui::CalcTextSize(top.c_str()).x;
  add_outlined_text(list, {low.x + size.x - top_width, text_y}, IM_COL32_WHITE, top);
}

/// A swatch and its meaning, one below the other from `corner`.
void color_key(vec2 corner, int row, vec3 color, const std::string& text) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float font = ImGui::GetFontSize();
  const vec2 low = corner + vec2(0, 1.35f * font * static_cast<float>(row));
  list.AddRectFilled(to_im(low), to_im(low + vec2(1.4f, 1) * font),
                     ImGui::ColorConvertFloat4ToU32({color.x, color.y, color.z, 1}));
  list.AddRect(to_im(low), to_im(low + vec2(1.4f, 1) * font), IM_COL32(90, 90, 90, 255));
  add_outlined_text(list, low + vec2(1.9f, 0) * font, IM_COL32_WHITE, text);
}

/// Behind `rows` of color_key() that end at `corner`.
void key_background(vec2 corner, int rows, float width) {
  const float font = ImGui::GetFontSize();
  const vec2 low = corner - vec2(0.5f, 1.35f * static_cast<float>(rows) + 0.4f) * font;
  const vec2 high = corner + vec2(width, 0.1f) * font;
  ImGui::GetBackgroundDrawList()->AddRectFilled(to_im(low), to_im(high), IM_COL32(18, 18, 18, 215),
                                                0.3f * font);
}

/// What the colours of types and of false colour mean.
void picture_keys(const UiState& ui, const Session& session) {
  const float font = ImGui::GetFontSize();
  const vec2 corner = vec2(ui.layout.picture.min.x, ui.layout.picture.max.y) + vec2(1, -1) * font;
  if (session.status().painted == ShownPicture::type && session.cache() != nullptr) {
    const auto& types = session.cache()->info().types;
    const int rows = static_cast<int>(std::min<size_t>(types.size(), 8));
    key_background(corner, rows, 9);
    for (int i = 0; i < rows; ++i) {
      color_key(corner, i - rows, type_color(static_cast<size_t>(i)),
                printable(types[static_cast<size_t>(i)].name, 30));
    }
  }
  if (!session.view().false_color || session.shown_image() == nullptr) return;
  constexpr int stops = static_cast<int>(false_color_high - false_color_low);
  key_background(corner, stops, 7);
  for (int i = 0; i < stops; ++i) {
    const float low = false_color_high - 1 - static_cast<float>(i);
    color_key(corner, i - stops, false_color(low + 0.5f),
              fmt::format("{:+.0f} to {:+.0f}", low, low + 1));
  }
}

/// When frames are coarse, and what follows at rest.
void budget_rows(UiState& ui, Session& session) {
  ViewState& view = session.view();
  row_label("coarse at");
  ImGui::SliderFloat("##frame_ms", &view.frame_ms, 0, largest_frame_ms,
                     view.frame_ms > 0 ? "%.0f ms" : "never",
                     ImGuiSliderFlags_AlwaysClamp | ImGuiSliderFlags_Logarithmic);
  note_item(ui, "view.frame_ms");
  if (!is_finite(view.frame_ms)) view.frame_ms = 0;
  view.frame_ms = std::clamp(view.frame_ms, 0.0f, largest_frame_ms);
  if (!session.info().has_reference) return;
  ImGui::Checkbox("all samples, traced, at rest", &view.refine);
  note_item(ui, "view.refine");
}

/// A slider over a positive quantity. True when it changed it.
bool trade_slider(const char* id, float& value, float low, float high, const char* format,
                  bool is_logarithmic) {
  float edited = value;
  const ImGuiSliderFlags scale =
      is_logarithmic ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None;
  if (!ImGui::SliderFloat(id, &edited, low, high, format, ImGuiSliderFlags_AlwaysClamp | scale) ||
      !is_finite(edited)) {
    return false;
  }
  value = edited;
  return true;
}

/// The one value of the trade's kind.
bool trade_value(UiState& ui, Trade& trade) {
  bool changed = false;
  float percent = 100 * trade.target_error;
  switch (trade.kind) {
    case TradeKind::manual:
      return false;
    case TradeKind::level:
      row_label("trade");
      changed = trade_slider("##level", trade.level, 0, 1, "fastest  -  exact", false);
      if (trade.level >= exact_level) trade.level = 1;
      note_item(ui, "trade.value");
      return changed;
    case TradeKind::time:
      row_label("one move");
      changed = trade_slider("##move_ms", trade.move_ms, 1, largest_frame_ms, "%.1f ms", true);
      note_item(ui, "trade.value");
      return changed;
    case TradeKind::error:
      row_label("error");
      changed = trade_slider("##target_error", percent, 0.01f, 30, "%.2f %%", true);
      if (changed) trade.target_error = percent / 100;
      note_item(ui, "trade.value");
      return changed;
  }
  return false;
}

std::string records_name(const RecordChoice& records) {
  return records.is_set() ? fmt::format("{:.2g} records, {}", records.average,
                                        label_of(cache_format_labels, records.format))
                          : "records as opened";
}

/// What the trade has come to, and what is still to come.
std::string trade_text(const UiState& ui, const Workspace& workspace) {
  const ViewState& view = workspace.session()->view();
  if (!workspace.can_trade()) return "these records cannot be prepared again";
  const LoadStatus status = workspace.trade_status();
  const std::string percent =
      ui.show_timings && status.working ? fmt::format(" {:.0f} %", 100 * status.fraction) : "";
  const bool is_planned = view.records == workspace.records();
  const std::optional<TradePlan>& plan = workspace.trade_plan();
  if (!plan) {
    const bool is_open = view.records.is_set() && is_planned;
    return is_open ? records_name(view.records) : "measuring this view" + percent;
  }
  std::string text = plan->is_met ? "" : "at best ";
  text += records_name(plan->records);
  if (!is_planned) return text + ": preparing" + percent;
  if (ui.show_timings) text += fmt::format(", {:.1f} ms", plan->move_ms);
  return text + fmt::format(", error {:.2g} %", 100 * plan->error);
}

/// Time against error: by one value, or each setting by itself.
void trade_rows(UiState& ui, Workspace& workspace) {
  ViewState& view = workspace.session()->view();
  Trade& trade = view.trade;
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "SPEED AGAINST ERROR");
  const bool chosen = choose(ui, "trade", trade_kind_labels, trade.kind, [&](TradeKind kind) {
    return kind == TradeKind::manual || workspace.can_trade();
  });
  if (trade_value(ui, trade) || chosen) apply_trade(view);
  if (trade.kind == TradeKind::manual && !view.records.is_set()) return;
  const std::string text = trade_text(ui, workspace);
  const bool is_missed = workspace.trade_plan() && !workspace.trade_plan()->is_met;
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(is_missed ? accent_color : dim_color), "%s",
                     text.c_str());
  note_item(ui, "trade.plan");
}

/// The tone curve, or false colour in its place. The curve config is there where it can be shown.
void curve_row(UiState& ui, ViewState& view, bool has_config) {
  row_label("curve");
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float count = has_config ? 4 : 3;
  const float width =
      std::max(1.0f, (ImGui::GetContentRegionAvail().x - (count - 1) * gap) / count);
  for (const Label<ToneCurve>& row : tone_curve_labels) {
    if (row.value == ToneCurve::config && !has_config) continue;
    const bool lit = !view.false_color && view.display.curve == row.value;
    if (segment_button(std::string(row.name).c_str(), lit, true, width)) {
      view.display.curve = row.value;
      view.false_color = false;
    }
    note_item(ui, fmt::format("view.curve.{}", row.name));
    ImGui::SameLine(0, gap);
  }
  if (segment_button("false", view.false_color, true, width)) view.false_color = !view.false_color;
  note_item(ui, "view.false_color");
}

/// How the frame came about, where that is not its records in all pixels.
std::string quality_text(const SessionStatus& status) {
  if (status.painted != ShownPicture::frame) return {};
  if (status.refined) return ", all samples traced";
  return status.pixels == PixelShare::quarter ? ", coarse" : "";
}

/// What stands at the right end: what goes on, what happened last, or a hint.
std::string news_line(const UiState& ui, const Workspace& workspace) {
  const LoadStatus load = workspace.load_status();
  if (load.working && ui.show_timings) {
    return fmt::format("{} {:.0f} %", load.stage.empty() ? "opening" : load.stage,
                       100 * load.fraction);
  }
  if (!workspace.notice().text.empty()) return workspace.notice().text;
  return "drag a light in the picture,  ? shows the keys";
}

void status_line(UiState& ui, const Workspace& workspace) {
  const Session* session = workspace.session();
  std::string problem = session != nullptr ? session->status().problem : "";
  if (problem.empty() && workspace.notice().is_problem) problem = workspace.notice().text;
  if (!problem.empty()) {
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(problem_color), "%s", problem.c_str());
    return;
  }
  if (session != nullptr) {
    ImGui::TextUnformatted(scene_line(*session).c_str());
    ImGui::SameLine(0, 2 * ImGui::GetFontSize());
    ImGui::TextDisabled("%s", work_line(ui, *session).c_str());
    ImGui::SameLine();
  }
  const std::string news = news_line(ui, workspace);
  const float left = ui.layout.status.max.x - ImGui::CalcTextSize(news.c_str()).x -
                     ImGui::GetStyle().WindowPadding.x;
  if (ImGui::GetCursorScreenPos().x >= left && workspace.notice().text.empty()) return;
  ImGui::SetCursorPosX(std::max(ImGui::GetCursorPosX(), left - ui.layout.status.min.x));
  if (workspace.notice().text.empty()) {
    ImGui::TextDisabled("%s", news.c_str());
  } else {
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(accent_color), "%s", news.c_str());
  }
}

}  // namespace

void view_panel(UiState& ui, Workspace& workspace) {
  Session& session = *workspace.session();
  ViewState& view = session.view();
  const SessionInfo& info = session.info();
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "PICTURE");
  choose(
      ui, "view", shown_picture_labels, view.shown,
      [&](ShownPicture shown) {
        if (shown == ShownPicture::visibility) return info.can_trace;
        return !needs_reference(shown) || info.has_reference;
      },
      3);

  row_label("exposure");
  ImGui::SliderFloat("##exposure", &view.display.exposure, -largest_exposure, largest_exposure,
                     "%+.2f stops", ImGuiSliderFlags_AlwaysClamp);
  note_item(ui, "view.exposure");
  if (!is_finite(view.display.exposure)) view.display.exposure = 0;
  view.display.exposure = std::clamp(view.display.exposure, -largest_exposure, largest_exposure);
  curve_row(ui, view, workspace.has_config_view());
  row_label("scale");
  choose(ui, "heatmap", heat_range_labels, view.heat_range);
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "SHADOWS");
  choose(
      ui, "shadows", shadow_method_labels, view.shadows,
      [&](ShadowMethod method) {
        if (method == ShadowMethod::none) return true;
        return info.can_trace && (method != ShadowMethod::members || info.has_members);
      },
      4);
  trade_rows(ui, workspace);
  budget_rows(ui, session);
}

void status_bar(UiState& ui, const Workspace& workspace) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding,
                      {ImGui::GetStyle().WindowPadding.x, 0.4f * ImGui::GetFontSize()});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.1f, 0.1f, 0.1f, 1));
  begin_fixed_window("status", ui.layout.status);
  status_line(ui, workspace);
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

void picture_legend(const UiState& ui, const Session& session) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const SessionStatus& status = session.status();
  const vec2 corner = ui.layout.picture.min + vec2(1, 0.7f) * ImGui::GetFontSize();
  const ShownPicture wanted = session.view().shown;
  const bool missing = wanted == ShownPicture::predicted && session.info().predicted_error.empty();
  const bool waiting = status.outdated && needs_reference(wanted);
  if (ui.show_snapshot && ui.snapshots.current() != nullptr) {
    add_outlined_text(list, corner, accent_color,
                      fmt::format("snapshot {};  tab flips back", ui.snapshots.selected() + 1));
    return;
  }
  std::string text(label_of(shown_picture_labels, status.painted));
  text += quality_text(status);
  if (missing) {
    text += "; this cache holds no predicted error";
  } else if (waiting && status.painted == wanted) {
    text += ", out of date until the light rests";
  } else if (waiting) {
    text += fmt::format(", the {} follows when the light rests",
                        label_of(shown_picture_labels, wanted));
  }
  add_outlined_text(list, corner, waiting || missing ? accent_color : IM_COL32(220, 220, 220, 255),
                    text);
  picture_keys(ui, session);
  if (status.heat_range > 0) heat_scale(ui, heat_unit(status.painted), status.heat_range);
}

}  // namespace relume

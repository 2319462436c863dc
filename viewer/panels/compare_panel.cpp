#include "viewer/panels/compare_panel.h"

#include <fmt/format.h>

#include "viewer/panels/widgets.h"

namespace relume {
namespace {

constexpr int buttons_per_row = 8;

float button_width(int per_row) {
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float room = ImGui::GetContentRegionAvail().x - gap * static_cast<float>(per_row - 1);
  return std::max(1.0f, room / static_cast<float>(per_row));
}

void snapshot_buttons(UiState& ui) {
  Snapshots& snapshots = ui.snapshots;
  const float width = button_width(buttons_per_row);
  for (int i = 0; i < static_cast<int>(snapshots.all().size()); ++i) {
    if (i % buttons_per_row != 0) ImGui::SameLine(0, ImGui::GetStyle().ItemInnerSpacing.x);
    const std::string label = fmt::format("{}##snapshot", i + 1);
    if (segment_button(label.c_str(), snapshots.selected() == i, true, width)) snapshots.select(i);
    note_item(ui, fmt::format("snapshot.{}", i + 1));
  }
}

}  // namespace

void compare_panel(UiState& ui, Session& session) {
  const bool has_any = ui.snapshots.current() != nullptr;
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(dim_color), "SNAPSHOTS");
  const float width = button_width(4);
  if (segment_button("take", false, true, width)) ui.snapshots.take(session);
  note_item(ui, "snapshot.take");
  ImGui::SameLine(0, gap);
  if (segment_button("flip", ui.show_snapshot, has_any, width)) {
    ui.show_snapshot = !ui.show_snapshot;
  }
  note_item(ui, "snapshot.flip");
  ImGui::SameLine(0, gap);
  if (segment_button("wipe", ui.is_wiping, has_any, width)) ui.is_wiping = !ui.is_wiping;
  note_item(ui, "snapshot.wipe");
  ImGui::SameLine(0, gap);
  if (segment_button("restore", false, has_any, width)) restore_snapshot(ui, session.view());
  note_item(ui, "snapshot.restore");
  snapshot_buttons(ui);
}

void restore_snapshot(const UiState& ui, ViewState& view) {
  const Snapshot* snapshot = ui.snapshots.current();
  if (snapshot == nullptr) return;
  view.lights = snapshot->view.lights;
  view.solo_lights = snapshot->view.solo_lights;
  view.selected_light = snapshot->view.selected_light;
  view.shadows = snapshot->view.shadows;
}

Rect snapshot_area(const UiState& ui) {
  Rect area = ui.layout.picture;
  if (ui.snapshots.current() == nullptr || !(ui.show_snapshot || ui.is_wiping)) {
    return {area.min, area.min};
  }
  if (!ui.show_snapshot) area.max.x = std::round(area.min.x + ui.wipe * area.size().x);
  return area;
}

void wipe_line(UiState& ui) {
  ui.wipe_handle.reset();
  if (ui.snapshots.current() == nullptr || !ui.is_wiping || ui.show_snapshot) return;
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const Rect& area = ui.layout.picture;
  const float font = ImGui::GetFontSize();
  const vec2 top(snapshot_area(ui).max.x, area.min.y);
  const vec2 bottom(top.x, area.max.y);
  const vec2 handle(top.x, std::round(area.min.y + 0.8f * area.size().y));
  list.AddLine(to_im(top), to_im(bottom), IM_COL32(0, 0, 0, 140), 3);
  list.AddLine(to_im(top), to_im(bottom), IM_COL32(235, 235, 235, 230), 1);
  list.AddCircleFilled(to_im(handle), 0.5f * font, IM_COL32(30, 30, 30, 220), 20);
  list.AddCircle(to_im(handle), 0.5f * font, IM_COL32_WHITE, 20, 1.5f);
  add_outlined_text(list, top + vec2(-2.2f, 0.7f) * font, IM_COL32_WHITE,
                    fmt::format("{}", ui.snapshots.selected() + 1));
  add_outlined_text(list, top + vec2(0.6f, 0.7f) * font, IM_COL32_WHITE, "live");
  ui.wipe_handle = handle;
  ui.items.note("wipe", {handle - 2.0f, handle + 2.0f});
}

}  // namespace relume

#pragma once

#include <imgui.h>

#include <array>
#include <string>

#include "core/base/label.h"
#include "viewer/panels/ui_state.h"

namespace relume {

inline ImVec2 to_im(vec2 v) {
  return {v.x, v.y};
}
inline vec2 from_im(ImVec2 v) {
  return {v.x, v.y};
}

/// Colours of the interface that are not in ImGui's style.
inline constexpr ImU32 accent_color = IM_COL32(255, 176, 66, 255);
inline constexpr ImU32 lit_color = IM_COL32(186, 186, 186, 255);
inline constexpr ImU32 problem_color = IM_COL32(255, 110, 100, 255);
inline constexpr ImU32 dim_color = IM_COL32(160, 160, 160, 255);

/// Dark, neutral grey (so that the picture's colours are judged right), and a readable font: DejaVu
/// Sans where installed, otherwise ImGui's own. `scale` 1 = 96 dpi. Call once, before the renderer.
void apply_theme(float scale);

/// Notes where ImGui's last item is, unless it is scrolled out of sight, and shows its tip (tip_of)
/// when the pointer has been there for a while.
void note_item(UiState& ui, std::string_view name);

/// The pointer stays where a tip will come.
bool is_tip_due(const UiState& ui);

/// Starts a row: `label` at the left, the next item fills the rest.
void row_label(const char* label);

/// One of several equally wide buttons in a row, lit when `lit`. True when clicked.
bool segment_button(const char* label, bool lit, bool enabled, float width);

/// A window without decoration that covers `rect`. Call ImGui::End() whatever it returns.
void begin_fixed_window(const char* name, const Rect& rect);

/// Text with a dark edge, readable over any picture.
void add_outlined_text(ImDrawList& list, vec2 position, ImU32 color, const std::string& text);

/// Rows of `per_row` buttons, one per label; the items are named "group.label". `enabled` says
/// which can be chosen. True when the value changed.
template <class E, size_t N, class Enabled>
bool choose(UiState& ui, const std::string& group, const std::array<Label<E>, N>& labels, E& value,
            const Enabled& enabled, size_t per_row = N) {
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x;
  const float width =
      std::max(1.0f, (ImGui::GetContentRegionAvail().x - gap * static_cast<float>(per_row - 1)) /
                         static_cast<float>(per_row));
  bool changed = false;
  ImGui::PushID(group.c_str());
  for (size_t i = 0; i < N; ++i) {
    const Label<E>& row = labels[i];
    if (i % per_row != 0) ImGui::SameLine(0, gap);
    const std::string label(row.name);
    if (segment_button(label.c_str(), row.value == value, enabled(row.value), width)) {
      changed = changed || value != row.value;
      value = row.value;
    }
    note_item(ui, group + "." + label);
  }
  ImGui::PopID();
  return changed;
}

template <class E, size_t N>
bool choose(UiState& ui, const std::string& group, const std::array<Label<E>, N>& labels,
            E& value) {
  return choose(ui, group, labels, value, [](E) { return true; });
}

}  // namespace relume

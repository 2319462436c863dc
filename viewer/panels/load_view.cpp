#include "viewer/panels/load_view.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

std::string progress_text(const UiState& ui, const LoadStatus& status) {
  if (!status.problem.empty()) return status.problem;
  if (status.stage.empty()) return fmt::format("opening {}", printable(status.input, 80));
  std::string text =
      fmt::format("{}  {:.0f} %", printable(status.stage, 80), 100 * status.fraction);
  if (ui.show_timings && status.seconds_left >= 0 && status.fraction < 1) {
    text += fmt::format(",  {:.0f} s left", std::ceil(status.seconds_left));
  }
  return text;
}

}  // namespace

void load_view(UiState& ui, const Workspace& workspace) {
  const LoadStatus status = workspace.load_status();
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float font = ImGui::GetFontSize();
  const vec2 size(20 * font, 0.5f * font);
  const Rect& area = ui.layout.picture;
  const vec2 low(std::round(area.center().x - 0.5f * size.x), area.max.y - 4 * font);
  const std::string text = progress_text(ui, status);
  const float width = ImGui::CalcTextSize(text.c_str()).x;
  add_outlined_text(list, {std::round(area.center().x - 0.5f * width), low.y - 1.6f * font},
                    status.problem.empty() ? IM_COL32_WHITE : problem_color, text);
  list.AddRectFilled(to_im(low), to_im(low + size), IM_COL32(40, 40, 40, 220), 0.25f * font);
  const vec2 done(size.x * static_cast<float>(status.fraction), size.y);
  if (done.x > 0) list.AddRectFilled(to_im(low), to_im(low + done), accent_color, 0.25f * font);
}

}  // namespace relume

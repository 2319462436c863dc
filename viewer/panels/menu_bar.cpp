#include "viewer/panels/menu_bar.h"

#include <fmt/format.h>

#include <cctype>

#include "core/base/error.h"
#include "viewer/panels/actions.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

void recent_items(UiState& ui, Workspace& workspace) {
  const std::vector<std::string> files = workspace.recent_files();
  if (files.empty()) return;
  ImGui::Separator();
  ImGui::TextDisabled("Recent");
  for (size_t i = 0; i < files.size(); ++i) {
    const std::string label = fmt::format("{}##{}", printable(files[i], 80), i);
    if (ImGui::MenuItem(label.c_str())) workspace.open(files[i]);
    note_item(ui, fmt::format("menu.recent.{}", i + 1));
  }
  ImGui::Separator();
}

void menu(UiState& ui, Workspace& workspace, ActionGroup group) {
  const std::string title(label_of(action_group_labels, group));
  const bool open = ImGui::BeginMenu(title.c_str());
  std::string item = "menu." + title;
  item[5] = static_cast<char>(std::tolower(static_cast<unsigned char>(item[5])));
  if (!open) {
    note_item(ui, item);
    return;
  }
  for (const Action& action : all_actions()) {
    if (action.group != group) continue;
    if (std::string_view(action.name) == "quit") recent_items(ui, workspace);
    if (ImGui::MenuItem(action.label, action.shown_key, false, is_enabled(action, workspace))) {
      action.act(ui, workspace);
    }
    note_item(ui, fmt::format("menu.{}", action.name));
  }
  ImGui::EndMenu();
}

/// The file's name, with a mark where edits are not saved.
std::string title_of(const Workspace& workspace) {
  if (workspace.session() == nullptr) return {};
  std::string title = workspace.document().empty() ? workspace.session()->info().title
                                                   : workspace.document().filename().string();
  return printable(title, 60) + (workspace.is_modified() ? " *" : "");
}

}  // namespace

void menu_bar(UiState& ui, Workspace& workspace) {
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.1f, 0.1f, 0.1f, 1));
  ImGui::PushStyleColor(ImGuiCol_MenuBarBg, ImVec4(0.1f, 0.1f, 0.1f, 1));
  const float room = ui.layout.menu.size().y - ImGui::GetFontSize();
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding,
                      {ImGui::GetStyle().FramePadding.x, std::max(0.0f, 0.5f * room)});
  if (ImGui::BeginMainMenuBar()) {
    for (const Label<ActionGroup>& group : action_group_labels) menu(ui, workspace, group.value);
    const std::string title = title_of(workspace);
    const float left = ui.layout.menu.max.x - ImGui::CalcTextSize(title.c_str()).x -
                       2 * ImGui::GetStyle().WindowPadding.x;
    if (left > ImGui::GetCursorPosX()) {
      ImGui::SameLine(left);
      ImGui::TextDisabled("%s", title.c_str());
    }
    ImGui::EndMainMenuBar();
  }
  ImGui::PopStyleVar();
  ImGui::PopStyleColor(2);
}

}  // namespace relume

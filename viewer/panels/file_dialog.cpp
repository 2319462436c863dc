#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "core/scene/io/gltf.h"
#include "core/scene/io/pbrt.h"
#include "viewer/panels/menu_bar.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

using Purpose = FileDialog::Purpose;
namespace fs = std::filesystem;

constexpr size_t max_entries = 2000;

const char* title_of(Purpose purpose) {
  switch (purpose) {
    case Purpose::open:
      return "Open a scene, cache, session or file of lights";
    case Purpose::save:
      return "Save the session as";
    case Purpose::export_frame:
      return "Export the frame as .exr or .png";
    case Purpose::none:
      break;
  }
  return "";
}

bool is_offered(Purpose purpose, const fs::path& name) {
  const fs::path type = name.extension();
  if (purpose == Purpose::export_frame) return type == ".exr" || type == ".png";
  if (purpose == Purpose::save) return type == ".json";
  return type == ".json" || type == ".relume" || is_gltf_path(name) || is_pbrt_path(name);
}

/// Folders first, then files that can be meant, in order of their names.
std::vector<FileDialog::Entry> list_folder(Purpose purpose, const fs::path& folder) {
  std::vector<FileDialog::Entry> entries;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    const std::string name = it->path().filename().string();
    std::error_code unknown;
    const bool is_folder = it->is_directory(unknown);
    if (name.starts_with('.') || (!is_folder && !is_offered(purpose, name))) continue;
    entries.push_back({name, is_folder});
    if (entries.size() >= max_entries) break;
  }
  std::sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
    return std::pair(!a.is_folder, a.name) < std::pair(!b.is_folder, b.name);
  });
  return entries;
}

/// The folder of what stands in the box.
fs::path folder_of(const FileDialog& dialog) {
  const fs::path path(dialog.path.data());
  std::error_code unknown;
  if (path.empty()) return fs::current_path(unknown);
  if (fs::is_directory(path, unknown)) return path;
  return path.has_parent_path() ? path.parent_path() : fs::current_path(unknown);
}

void set_path(FileDialog& dialog, const fs::path& path) {
  dialog.path.fill(0);
  path.string().copy(dialog.path.data(), dialog.path.size() - 1);
}

void refresh(FileDialog& dialog) {
  const std::string folder = folder_of(dialog).string();
  if (folder == dialog.folder) return;
  dialog.folder = folder;
  dialog.entries = list_folder(dialog.purpose, folder);
}

/// A click enters a folder or puts a file into the box; true for a double click on a file.
bool entry_list(UiState& ui) {
  FileDialog& dialog = ui.dialog;
  bool accepted = false;
  const fs::path folder = fs::path(dialog.folder).lexically_normal();
  // The buttons stay below it.
  ImGui::BeginChild("entries", {0, -ImGui::GetFrameHeightWithSpacing()}, true);
  if (ImGui::Selectable("../")) set_path(dialog, (folder / "..").lexically_normal());
  note_item(ui, "dialog.entry...");
  for (const FileDialog::Entry& entry : dialog.entries) {
    const std::string label = printable(entry.name) + (entry.is_folder ? "/" : "");
    if (ImGui::Selectable(label.c_str(), false, ImGuiSelectableFlags_AllowDoubleClick)) {
      set_path(dialog, folder / entry.name);
      accepted = !entry.is_folder && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left);
    }
    note_item(ui, "dialog.entry." + entry.name);
  }
  ImGui::EndChild();
  return accepted;
}

void accept(UiState& ui, Workspace& workspace) {
  const std::string path = ui.dialog.path.data();
  std::error_code unknown;
  if (path.empty() || fs::is_directory(path, unknown)) return;
  const Purpose purpose = std::exchange(ui.dialog.purpose, Purpose::none);
  if (purpose == Purpose::open) workspace.open(path);
  if (purpose == Purpose::save) workspace.save(path);
  if (purpose == Purpose::export_frame) workspace.export_frame(path);
}

/// True when what was typed is meant.
bool path_box(UiState& ui) {
  ImGui::SetNextItemWidth(-1);
  if (ui.dialog.is_new) ImGui::SetKeyboardFocusHere();
  ui.dialog.is_new = false;
  const bool entered =
      ImGui::InputText("##path", ui.dialog.path.data(), ui.dialog.path.size(),
                       ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  note_item(ui, "dialog.path");
  return entered;
}

}  // namespace

void file_dialog(UiState& ui, Workspace& workspace) {
  if (ui.dialog.purpose == Purpose::none) return;
  refresh(ui.dialog);
  const vec2 size = glm::min(vec2(36, 21) * ImGui::GetFontSize(), ui.layout.picture.size());
  ImGui::SetNextWindowPos(to_im(ui.layout.picture.center()), ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize(to_im(glm::max(size, vec2(1))));
  ImGui::PushStyleColor(ImGuiCol_WindowBg, ImVec4(0.11f, 0.11f, 0.11f, 1));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowBorderSize, 1);
  if (ui.dialog.is_new) ImGui::SetNextWindowFocus();
  ImGui::Begin("file dialog", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::TextUnformatted(title_of(ui.dialog.purpose));
  bool accepted = path_box(ui);
  accepted = entry_list(ui) || accepted;
  const float width = 7 * ImGui::GetFontSize();
  accepted = segment_button("ok", true, true, width) || accepted;
  note_item(ui, "dialog.accept");
  ImGui::SameLine();
  const bool escaped = ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape), false);
  const bool cancelled = segment_button("cancel", false, true, width) || escaped;
  note_item(ui, "dialog.cancel");
  ImGui::End();
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  if (cancelled) {
    ui.dialog.purpose = Purpose::none;
  } else if (accepted) {
    accept(ui, workspace);
  }
}

}  // namespace relume

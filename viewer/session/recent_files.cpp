#include "viewer/session/recent_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/scene/io/json_node.h"

namespace relume {
namespace {

constexpr size_t max_recent = 10;
constexpr uint64_t max_list_bytes = 1 << 16;
constexpr size_t max_path_length = 4096;

std::filesystem::path list_file(const std::filesystem::path& folder) {
  return folder / "recent.json";
}

/// FNV-1a, 64 bits: names must not change between builds.
uint64_t stable_hash(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  return hash;
}

}  // namespace

std::filesystem::path default_state_folder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state != nullptr && state[0] == '/') return std::filesystem::path(state) / "relume";
  const char* home = std::getenv("HOME");
  if (home != nullptr && home[0] == '/') {
    return std::filesystem::path(home) / ".local" / "state" / "relume";
  }
  return {};
}

std::filesystem::path autosave_file(const std::filesystem::path& folder, const std::string& input) {
  return folder / fmt::format("autosave-{:016x}.json", stable_hash(input));
}

std::filesystem::path lights_file(const std::filesystem::path& folder, const std::string& text) {
  return folder / fmt::format("lights-{:016x}.json", stable_hash(text));
}

std::vector<std::string> read_recent_files(const std::filesystem::path& folder) {
  std::vector<std::string> files;
  if (folder.empty()) return files;
  try {
    const std::string path = list_file(folder).string();
    const JsonDocument document(read_text_file(path, max_list_bytes), path);
    for (const JsonNode& item : document.root().items(max_recent)) {
      files.push_back(item.text(max_path_length));
    }
  } catch (const Error&) {
    files.clear();
  }
  return files;
}

void add_recent_file(const std::filesystem::path& folder, const std::string& input) {
  if (folder.empty() || input.empty() || input.size() > max_path_length) return;
  std::vector<std::string> files = read_recent_files(folder);
  std::erase(files, input);
  files.insert(files.begin(), input);
  files.resize(std::min(files.size(), max_recent));
  std::string text = "[";
  for (size_t i = 0; i < files.size(); ++i)
    text += (i == 0 ? "\n  " : ",\n  ") + json_quoted(files[i]);
  try {
    make_folder(folder);
    write_file_atomic(list_file(folder), text + "\n]\n");
  } catch (const Error&) {
    return;  // a convenience: not worth an error
  }
}

}  // namespace relume

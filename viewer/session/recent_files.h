#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace relume {

/// Where a viewer keeps what it remembers between runs: "relume" in $XDG_STATE_HOME, or in
/// ~/.local/state; empty when neither is known.
std::filesystem::path default_state_folder();

/// The file in `folder` that saves the unsaved work on `input`. Its name tells inputs apart.
std::filesystem::path autosave_file(const std::filesystem::path& folder, const std::string& input);

/// A file in `folder` for lights written as `text`: other lights, another name.
std::filesystem::path lights_file(const std::filesystem::path& folder, const std::string& text);

/// What was opened last, newest first, at most ten; empty when the list cannot be read.
std::vector<std::string> read_recent_files(const std::filesystem::path& folder);

/// Puts `input` in front of the list. A list that cannot be written stays as it was.
void add_recent_file(const std::filesystem::path& folder, const std::string& input);

}  // namespace relume

#pragma once

#include <filesystem>
#include <functional>

#include "tests/viewer/display_live_window.h"

namespace relume::test {

/// Edits in which all kinds of edit come, and each is undone by its opposite.
inline constexpr int edits_per_cycle = 64;

struct SoakFigures {
  int edits = 0;
  double first_bytes = 0;  ///< allocated at rest, after the warm-up
  double last_bytes = 0;   ///< allocated at rest, after the last cycle
  double growth() const { return first_bytes > 0 ? last_bytes / first_bytes - 1 : 0; }
};

struct SoakParams {
  int cycles = 6;
  double seconds = 0;      ///< > 0: as many cycles as begin in so long, instead
  int warm_up_cycles = 2;  ///< before memory counts
  int drag_moves = 30;     ///< frames of a drag
  /// Called after each cycle that counts; empty: nobody is told.
  std::function<void(const SoakFigures& so_far)> report = {};
};

/// Works in the window as a person does who never pauses: every other edit drags a light; gains,
/// exposure, undo and redo, maps, lights added and taken away, saving and exporting come between.
/// Before each cycle of the middle third one of `inputs` is opened, in turn; there may be none.
/// What is changed is changed back, so that nothing has a reason to grow but the history. Files go
/// to `folder`.
SoakFigures soak(LiveWindow& window, Workspace& workspace, const std::vector<std::string>& inputs,
                 const std::filesystem::path& folder, const SoakParams& params);

}  // namespace relume::test

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/label.h"
#include "core/math/vec.h"

namespace relume {

/// What a step of a script does. One frame is drawn after each change of the input, a few more
/// after a click, and the session is given time to finish after every frame.
enum class StepKind {
  move,     ///< the pointer to `item`, or to `position`
  move_by,  ///< the pointer by `position`
  press,    ///< the left button
  release,
  click,       ///< moves to `item` (or `position`), presses and releases
  drag,        ///< from `item` by `position`, in four moves
  wheel,       ///< turns the wheel by position.x notches
  key,         ///< presses the key named `text`, or types its one character
  type,        ///< types `text`
  wait,        ///< until picture and panels show what was asked for
  resize,      ///< the window to `position`
  screenshot,  ///< writes the window to the file `text` (.png)
};

inline constexpr std::array step_kind_labels = {
    Label<StepKind>{StepKind::move, "move"},
    Label<StepKind>{StepKind::move_by, "move-by"},
    Label<StepKind>{StepKind::press, "press"},
    Label<StepKind>{StepKind::release, "release"},
    Label<StepKind>{StepKind::click, "click"},
    Label<StepKind>{StepKind::drag, "drag"},
    Label<StepKind>{StepKind::wheel, "wheel"},
    Label<StepKind>{StepKind::key, "key"},
    Label<StepKind>{StepKind::type, "type"},
    Label<StepKind>{StepKind::wait, "wait"},
    Label<StepKind>{StepKind::resize, "resize"},
    Label<StepKind>{StepKind::screenshot, "screenshot"},
};

struct ScriptStep {
  StepKind kind = StepKind::wait;
  std::string item;  ///< name in the ItemTable; empty = use position
  vec2 position{0};  ///< screen units
  std::string text;
  std::string place;  ///< "FILE:LINE", for messages
};

/// Input for the viewer, as a file or written out in code.
struct Script {
  std::vector<ScriptStep> steps;
};

/// Parses one step a line: the step's label, then its arguments; "#" starts a comment.
///
///     move X Y | move ITEM          drag ITEM DX DY
///     move-by DX DY                 wheel NOTCHES
///     press                         key KEY        (one character, enter, escape, tab or
///     backspace) release                       type TEXT      (to the end of the line) click X Y |
///     click ITEM        wait resize WIDTH HEIGHT           screenshot FILE.png
///
/// Throws Error(input) naming the line.
Script parse_script(const std::string& text, const std::string& place);

/// The same from a file of at most 1 MB.
Script load_script(const std::filesystem::path& path);

}  // namespace relume

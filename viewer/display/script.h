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
  click,          ///< moves to `item` (or `position`), presses and releases
  drag,           ///< from `item` by `position`, in four moves
  wheel,          ///< turns the wheel by position.x notches
  key,            ///< presses the key named `text`, or types its one character
  type,           ///< types `text`
  drop,           ///< drops the file `text` on the window
  wait,           ///< until picture and panels show what was asked for
  resize,         ///< the window to `position`
  renew_context,  ///< as after the driver lost the OpenGL context
  screenshot,     ///< writes the window to the file `text` (.png)
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
    Label<StepKind>{StepKind::drop, "drop"},
    Label<StepKind>{StepKind::wait, "wait"},
    Label<StepKind>{StepKind::resize, "resize"},
    Label<StepKind>{StepKind::renew_context, "renew-context"},
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
///     move X Y | move ITEM          click X Y | click ITEM
///     move-by DX DY                 drag ITEM DX DY
///     press                         wheel NOTCHES
///     release                       resize WIDTH HEIGHT
///     key KEY                       wait
///     type TEXT                     screenshot FILE.png
///     drop PATH                     renew-context
///
/// KEY is a character, or ctrl+LETTER, or the name of a key such as enter or page-up, both with
/// shift+ where wanted. TEXT and PATH go to the end of the line.
///
/// Throws Error(input) naming the line.
Script parse_script(const std::string& text, const std::string& place);

/// The same from a file of at most 1 MB.
Script load_script(const std::filesystem::path& path);

}  // namespace relume

#pragma once

#include "core/math/vec.h"
#include "viewer/display/gl_table.h"

namespace relume {

/// A framebuffer with an OpenGL 3.3 core context, current on the thread that made it. At most one
/// kind of surface may exist in a process: an off-screen context silently redirects the functions
/// of a window's on the same thread.
class Surface {
 public:
  virtual ~Surface() = default;

  virtual GlLoader loader() const = 0;
  /// Size of the framebuffer; 0 while a window is minimised.
  virtual ivec2 size_px() const = 0;
  /// Asks for another size; a window may get a different one.
  virtual void resize(ivec2 size_px) = 0;
  /// A new context in place of the present one, of which nothing can be used any more: what was
  /// made in it has to be made again, with functions loaded anew.
  virtual void renew_context() = 0;
  /// Shows what was drawn.
  virtual void present() = 0;
};

/// A surface that a person sees, with what arrives from mouse and keyboard.
class EventSurface : public Surface {
 public:
  virtual bool should_close() const = 0;
  /// The driver has thrown the context away (a graphics card that was reset or taken out). Always
  /// false where drivers do not tell.
  virtual bool is_context_lost() const = 0;
  /// Hands the input since the last frame to ImGui; before ImGui::NewFrame().
  virtual void begin_frame() = 0;
  /// There is input that begin_frame() has not shown to ImGui yet.
  virtual bool has_pending_keys() const = 0;
  /// Handles what has arrived, without waiting.
  virtual void poll_events() = 0;
  /// Sleeps until something arrives; false when nothing did for `seconds`.
  virtual bool wait_events(double seconds) = 0;
};

}  // namespace relume

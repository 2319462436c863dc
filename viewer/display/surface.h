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
  /// Shows what was drawn.
  virtual void present() = 0;
};

}  // namespace relume

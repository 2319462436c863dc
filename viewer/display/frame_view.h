#pragma once

#include "core/math/vec.h"
#include "viewer/display/gl_table.h"
#include "viewer/panels/placement.h"
#include "viewer/session/session.h"

namespace relume {

/// Draws a Picture as one textured rectangle. Needs its context current whenever it is used.
class FrameView {
 public:
  explicit FrameView(const GlTable& gl);
  ~FrameView();
  FrameView(const FrameView&) = delete;
  FrameView& operator=(const FrameView&) = delete;

  /// Draws the whole picture into `target`, cut off at `clip`, in a framebuffer of `size_px`; the
  /// rectangles are in its pixels, from the top left. The picture's pixels are uploaded when
  /// picture.version differs from the last one drawn. Smooth when smaller or slightly larger than
  /// life, with hard pixels from twice its size. Draws nothing when the picture or the rectangle is
  /// empty.
  void draw(const Picture& picture, const Rect& target, const Rect& clip, ivec2 size_px);

  /// The next picture is uploaded whatever its version.
  void forget() { version_ = 0; }

 private:
  void upload(const Picture& picture);

  const GlTable& gl_;
  GLuint program_ = 0;
  GLuint vertex_array_ = 0;
  GLuint texture_ = 0;
  GLint rectangle_uniform_ = -1;
  int width_ = 0;
  int height_ = 0;
  uint64_t version_ = 0;
};

}  // namespace relume

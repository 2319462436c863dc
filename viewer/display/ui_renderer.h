#pragma once

#include "viewer/display/gl_table.h"

struct ImDrawData;

namespace relume {

/// Draws Dear ImGui's lists. Debian's compiled OpenGL backend opens the system's OpenGL library by
/// itself and so cannot draw off screen; this one uses our table. Needs the ImGui context and the
/// OpenGL context current; make it after the fonts were added.
class UiRenderer {
 public:
  explicit UiRenderer(const GlTable& gl);
  ~UiRenderer();
  UiRenderer(const UiRenderer&) = delete;
  UiRenderer& operator=(const UiRenderer&) = delete;

  /// Draws over what is in the framebuffer. Nothing when it has no pixels.
  void draw(const ImDrawData& data);

 private:
  void make_vertex_layout();
  void upload_fonts();

  const GlTable& gl_;
  GLuint program_ = 0;
  GLuint vertex_array_ = 0;
  GLuint vertices_ = 0;
  GLuint indices_ = 0;
  GLuint fonts_ = 0;
  GLint rectangle_uniform_ = -1;
};

}  // namespace relume

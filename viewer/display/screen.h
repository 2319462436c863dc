#pragma once

#include "viewer/display/frame_view.h"
#include "viewer/display/ui_renderer.h"
#include "viewer/panels/ui_state.h"
#include "viewer/session/workspace.h"

namespace relume {

struct ScreenOptions {
  float scale = 1;           ///< of text and controls; 1 = 96 dpi
  bool show_timings = true;  ///< off: pictures do not depend on the clock
};

/// Everything that the viewer draws, the same in a window and off screen: the picture with the
/// panels over it. Owns the ImGui context; at most one at a time. Needs the OpenGL context current.
class Screen {
 public:
  Screen(Workspace& workspace, const GlTable& gl, const ScreenOptions& options);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Acts on ImGui's input, brings the workspace up to date and draws a frame. The caller has set
  /// ImGui's display size, time step and input. Draws nothing when the framebuffer is empty.
  void draw(ivec2 size_px);

  /// Where things stood in the last frame.
  const UiState& ui() const { return ui_; }
  /// No light is being dragged or edited.
  bool resting() const;
  /// The person asked to leave.
  bool quit() const { return ui_.quit; }
  /// A text field has the keyboard, so the caret has to blink.
  bool has_caret() const;

 private:
  /// An ImGui context that lives as long as this.
  struct Context {
    Context();
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
  };

  void build();
  void build_session(Session& session);
  void draw_picture(ivec2 size_px);
  const Picture& picture() const;

  Workspace& workspace_;
  const GlTable& gl_;
  Context context_;
  UiState ui_;
  FrameView frame_view_;
  FrameView snapshot_view_;
  uint64_t drawn_session_ = 0;  ///< whose picture frame_view_ holds; 0 = the preview
  UiRenderer ui_renderer_;
};

}  // namespace relume

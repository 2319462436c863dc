#pragma once

#include <optional>

#include "viewer/display/frame_view.h"
#include "viewer/display/surface.h"
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
  /// `gl` is loaded anew by renew_context().
  Screen(Workspace& workspace, GlTable& gl, const ScreenOptions& options);
  ~Screen();
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Acts on ImGui's input, brings the workspace up to date and draws a frame. The caller has set
  /// ImGui's display size, time step and input. Draws nothing when the framebuffer is empty.
  void draw(ivec2 size_px);

  /// Gives `surface`, the one that this draws to, a new context and makes everything in it anew.
  void renew_context(Surface& surface);

  /// Where things stood in the last frame.
  const UiState& ui() const { return ui_; }
  /// No light is being dragged or edited.
  bool resting() const;
  /// The person asked to leave.
  bool quit() const { return ui_.quit; }
  /// Frames are due though nothing happens: a caret blinks, or a tip will come.
  bool changes_by_itself() const;

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
  GlTable& gl_;
  Context context_;
  UiState ui_;
  /// What lives in the OpenGL context.
  struct Painters {
    explicit Painters(const GlTable& gl) : frame(gl), snapshot(gl), ui(gl) {}
    FrameView frame;
    FrameView snapshot;
    UiRenderer ui;
  };
  std::optional<Painters> painters_;  ///< always there but while the context is renewed
  uint64_t drawn_session_ = 0;        ///< whose picture painters_ holds; 0 = the preview
};

}  // namespace relume

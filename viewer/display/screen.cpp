#include "viewer/display/screen.h"

#include <imgui.h>

#include <utility>

#include "core/base/check.h"
#include "viewer/panels/compare_panel.h"
#include "viewer/panels/inspector.h"
#include "viewer/panels/keys.h"
#include "viewer/panels/light_panel.h"
#include "viewer/panels/load_view.h"
#include "viewer/panels/manipulator.h"
#include "viewer/panels/menu_bar.h"
#include "viewer/panels/picture_tools.h"
#include "viewer/panels/view_panel.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

constexpr float background = 0.085f;  // sRGB-encoded, around the picture

}  // namespace

Screen::Context::Context() {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;
  io.LogFilename = nullptr;
}

Screen::Context::~Context() {
  ImGui::DestroyContext();
}

Screen::Screen(Workspace& workspace, GlTable& gl, const ScreenOptions& options)
    : workspace_(workspace), gl_(gl) {
  ui_.show_timings = options.show_timings;
  apply_theme(options.scale);
  painters_.emplace(gl_);
}

Screen::~Screen() = default;

bool Screen::resting() const {
  const bool dragging =
      ui_.drag.grip != Grip::none && ui_.drag.grip != Grip::pan && ui_.drag.grip != Grip::wipe;
  return !dragging && !ui_.nudging && !ImGui::IsAnyItemActive();
}

bool Screen::changes_by_itself() const {
  return ImGui::GetIO().WantTextInput || is_tip_due(ui_);
}

void Screen::renew_context(Surface& surface) {
  painters_.reset();
  surface.renew_context();
  gl_ = load_gl_table(surface.loader());
  painters_.emplace(gl_);
}

void Screen::draw(ivec2 size_px) {
  CHECK(painters_.has_value());
  ImGui::NewFrame();
  build();
  ImGui::Render();
  workspace_.update(resting());
  if (size_px.x <= 0 || size_px.y <= 0) return;
  gl_.Viewport(0, 0, size_px.x, size_px.y);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.ClearColor(background, background, background, 1);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  draw_picture(size_px);
  painters_->ui.draw(*ImGui::GetDrawData());
}

void Screen::build() {
  const ImGuiIO& io = ImGui::GetIO();
  ui_.items.clear();
  ui_.tip = std::exchange(ui_.next_tip, {});
  handle_keys(ui_, workspace_);
  ui_.layout = make_layout(from_im(io.DisplaySize), ImGui::GetFontSize(), ui_.show_panel);
  if (Session* session = workspace_.session()) {
    build_session(*session);
  } else {
    const Picture& preview = workspace_.preview();
    ui_.placement = place_picture(ui_.layout.picture, vec2(preview.width, preview.height), {});
    load_view(ui_, workspace_);
  }
  menu_bar(ui_, workspace_);
  status_bar(ui_, workspace_);
  help_window(ui_);
  file_dialog(ui_, workspace_);
}

void Screen::build_session(Session& session) {
  if (ui_.snapshots_of != workspace_.session_number()) ui_.snapshots.clear();
  ui_.snapshots_of = workspace_.session_number();
  ui_.snapshots.follow(session.view(), resting());
  const vec2 picture_px(session.info().width, session.info().height);
  ui_.placement = place_picture(ui_.layout.picture, picture_px, session.view());
  light_manipulator(ui_, session);
  wipe_line(ui_);
  picture_legend(ui_, session);
  pixel_inspector(ui_, session);
  picture_histogram(ui_, session, workspace_.session_number());
  tool_bar(ui_, session);
  if (!ui_.show_panel) return;
  begin_fixed_window("panel", ui_.layout.panel);
  view_panel(ui_, workspace_);
  compare_panel(ui_, session);
  ImGui::Separator();
  light_panel(ui_, session);
  ImGui::End();
}

const Picture& Screen::picture() const {
  const Session* session = workspace_.session();
  return session != nullptr ? session->picture() : workspace_.preview();
}

void Screen::draw_picture(ivec2 size_px) {
  if (drawn_session_ != workspace_.session_number()) painters_->frame.forget();
  drawn_session_ = workspace_.session_number();
  const vec2 scale = from_im(ImGui::GetIO().DisplayFramebufferScale);
  const Placement& placement = ui_.placement;
  const vec2 picture_px(picture().width, picture().height);
  const Rect target{placement.origin * scale, placement.screen_from_film(picture_px) * scale};
  const Rect clip{placement.area.min * scale, placement.area.max * scale};
  painters_->frame.draw(picture(), target, clip, size_px);
  const Rect part = snapshot_area(ui_);
  if (const Snapshot* snapshot = ui_.snapshots.current(); snapshot && part.size().x > 0) {
    painters_->snapshot.draw(snapshot->picture, target, {part.min * scale, part.max * scale},
                             size_px);
  }
}

}  // namespace relume

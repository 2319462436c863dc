#include "viewer/display/screen.h"

#include <imgui.h>

#include "viewer/panels/keys.h"
#include "viewer/panels/light_panel.h"
#include "viewer/panels/manipulator.h"
#include "viewer/panels/view_panel.h"
#include "viewer/panels/widgets.h"

namespace relume {
namespace {

constexpr float background = 0.085f;  // sRGB-encoded, around the picture

/// The fonts have to stand before the renderer uploads them.
const GlTable& with_theme(const GlTable& gl, float scale) {
  apply_theme(scale);
  return gl;
}

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

Screen::Screen(Session& session, const GlTable& gl, const ScreenOptions& options)
    : session_(session), gl_(gl), frame_view_(gl), ui_renderer_(with_theme(gl, options.scale)) {
  ui_.show_timings = options.show_timings;
}

Screen::~Screen() = default;

bool Screen::resting() const {
  const bool dragging = ui_.drag.grip != Grip::none && ui_.drag.grip != Grip::pan;
  return !dragging && !ImGui::IsAnyItemActive();
}

bool Screen::has_caret() const {
  return ImGui::GetIO().WantTextInput;
}

void Screen::draw(ivec2 size_px) {
  ImGui::NewFrame();
  build();
  ImGui::Render();
  session_.update(resting());
  if (size_px.x <= 0 || size_px.y <= 0) return;
  gl_.Viewport(0, 0, size_px.x, size_px.y);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.ClearColor(background, background, background, 1);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  draw_picture(size_px);
  ui_renderer_.draw(*ImGui::GetDrawData());
}

void Screen::build() {
  const ImGuiIO& io = ImGui::GetIO();
  ui_.items.clear();
  handle_keys(ui_, session_);
  ui_.layout = make_layout(from_im(io.DisplaySize), ImGui::GetFontSize(), ui_.show_panel);
  const vec2 picture_px(session_.info().width, session_.info().height);
  ui_.placement = place_picture(ui_.layout.picture, picture_px, session_.view());
  light_manipulator(ui_, session_);
  picture_legend(ui_, session_);
  if (ui_.show_panel) {
    begin_fixed_window("panel", ui_.layout.panel);
    view_panel(ui_, session_);
    ImGui::Spacing();
    ImGui::Separator();
    ImGui::Spacing();
    light_panel(ui_, session_);
    ImGui::End();
  }
  status_bar(ui_, session_);
  help_window(ui_);
}

void Screen::draw_picture(ivec2 size_px) {
  const vec2 scale = from_im(ImGui::GetIO().DisplayFramebufferScale);
  const Picture& picture = session_.picture();
  const Placement& placement = ui_.placement;
  const vec2 picture_px(picture.width, picture.height);
  const Rect target{placement.origin * scale, placement.screen_from_film(picture_px) * scale};
  const Rect clip{placement.area.min * scale, placement.area.max * scale};
  frame_view_.draw(picture, target, clip, size_px);
}

}  // namespace relume

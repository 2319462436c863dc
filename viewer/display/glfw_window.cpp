#include "viewer/display/glfw_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include "core/base/error.h"
#include "core/base/timer.h"

namespace relume {
namespace {

constexpr const char* offscreen_mend = "run it on a desktop, or draw to files with --offscreen DIR";

/// GLFW's last complaint on this thread.
std::string glfw_problem(const char* otherwise) {
  const char* description = nullptr;
  glfwGetError(&description);
  return description == nullptr ? otherwise : printable(description);
}

GlFunction load_gl_function(const char* name) {
  return glfwGetProcAddress(name);
}

}  // namespace

bool display_available() {
  if (!glfwInit()) return false;
  glfwTerminate();
  return true;
}

GlfwWindow::GlfwWindow(const std::string& title, ivec2 size) : title_(title) {
  if (!glfwInit()) {
    throw output_error("window", glfw_problem("there is no display"), offscreen_mend);
  }
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  try {
    open(size);
  } catch (...) {
    glfwTerminate();
    throw;
  }
}

/// A context that tells when it was lost, where the driver can.
GLFWwindow* GlfwWindow::create(ivec2 size) const {
  for (const int robustness : {GLFW_LOSE_CONTEXT_ON_RESET, GLFW_NO_ROBUSTNESS}) {
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, robustness);
    GLFWwindow* window = glfwCreateWindow(size.x, size.y, title_.c_str(), nullptr, nullptr);
    if (window != nullptr) return window;
  }
  return nullptr;
}

void GlfwWindow::open(ivec2 size) {
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = create(size);
  if (window_ == nullptr) {
    throw output_error("window", glfw_problem("it cannot be opened"), offscreen_mend);
  }
  glfwMakeContextCurrent(window_);
  for (const char* name :
       {"glGetGraphicsResetStatus", "glGetGraphicsResetStatusARB", "glGetGraphicsResetStatusKHR"}) {
    const bool has_it = glfwGetWindowAttrib(window_, GLFW_CONTEXT_ROBUSTNESS) != GLFW_NO_ROBUSTNESS;
    if (reset_status_ == nullptr && has_it) {
      reset_status_ = reinterpret_cast<unsigned (*)()>(glfwGetProcAddress(name));
    }
  }
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, [](GLFWwindow* handle, int key, int, int action, int modifiers) {
    auto* window = static_cast<GlfwWindow*>(glfwGetWindowUserPointer(handle));
    if (action == GLFW_PRESS && key >= 0) window->presses_.push_back({key, modifiers});
  });
  glfwSetDropCallback(window_, [](GLFWwindow* handle, int count, const char** paths) {
    const auto* window = static_cast<const GlfwWindow*>(glfwGetWindowUserPointer(handle));
    for (int i = 0; i < count && window->drop_; ++i) window->drop_(paths[i]);
  });
}

void GlfwWindow::close() {
  reset_status_ = nullptr;
  glfwDestroyWindow(window_);
  window_ = nullptr;
}

GlfwWindow::~GlfwWindow() {
  close();
  glfwTerminate();
}

void GlfwWindow::renew_context() {
  ivec2 size(1);
  ivec2 position(0);
  glfwGetWindowSize(window_, &size.x, &size.y);
  glfwGetWindowPos(window_, &position.x, &position.y);
  const bool had_input = has_input_;
  if (had_input) disconnect_input();
  close();
  // The size is as the window had it, already scaled.
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_FALSE);
  open(size);
  glfwSetWindowPos(window_, position.x, position.y);
  if (had_input) connect_input();
}

bool GlfwWindow::is_context_lost() const {
  return reset_status_ != nullptr && reset_status_() != 0;
}

GlLoader GlfwWindow::loader() const {
  return load_gl_function;
}

ivec2 GlfwWindow::size_px() const {
  ivec2 size(0);
  glfwGetFramebufferSize(window_, &size.x, &size.y);
  return size;
}

void GlfwWindow::resize(ivec2 size_px) {
  glfwSetWindowSize(window_, std::max(1, size_px.x), std::max(1, size_px.y));
  constexpr double patience_s = 2;
  const Timer timer;
  while (this->size_px() != size_px && timer.seconds() < patience_s) wait_events(0.05);
}

void GlfwWindow::present() {
  glfwSwapBuffers(window_);
}

float GlfwWindow::ui_scale() const {
  vec2 content(1);
  glfwGetWindowContentScale(window_, &content.x, &content.y);
  ivec2 window(1);
  glfwGetWindowSize(window_, &window.x, &window.y);
  // Where window units are already larger than pixels, only the rest is ours to scale.
  const float pixels_per_unit =
      static_cast<float>(std::max(1, size_px().x)) / static_cast<float>(std::max(1, window.x));
  return std::clamp(content.x / pixels_per_unit, 0.5f, 8.0f);
}

bool GlfwWindow::should_close() const {
  return glfwWindowShouldClose(window_) != 0;
}

void GlfwWindow::connect_input() {
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  has_input_ = true;
}

void GlfwWindow::disconnect_input() {
  ImGui_ImplGlfw_Shutdown();
  has_input_ = false;
}

void GlfwWindow::begin_frame() {
  ImGui_ImplGlfw_NewFrame();
  replay_key();
}

/// ImGui looks at which keys are down once a frame: one that went down and up in between, as quick
/// fingers and slow frames have it, is shown as down for the frame that follows, with the modifiers
/// that it was pressed with.
void GlfwWindow::replay_key() {
  ImGuiIO& io = ImGui::GetIO();
  const auto is_down = [this](int key) { return glfwGetKey(window_, key) == GLFW_PRESS; };
  if (replayed_key_ >= 0) {
    io.KeysDown[replayed_key_] = is_down(replayed_key_);
    io.KeyCtrl = is_down(GLFW_KEY_LEFT_CONTROL) || is_down(GLFW_KEY_RIGHT_CONTROL);
    io.KeyShift = is_down(GLFW_KEY_LEFT_SHIFT) || is_down(GLFW_KEY_RIGHT_SHIFT);
    io.KeyAlt = is_down(GLFW_KEY_LEFT_ALT) || is_down(GLFW_KEY_RIGHT_ALT);
    replayed_key_ = -1;
    return;
  }
  while (!presses_.empty()) {
    const KeyPress press = presses_.front();
    presses_.pop_front();
    if (press.key >= GLFW_KEY_LEFT_SHIFT) continue;
    io.KeysDown[press.key] = true;
    io.KeyCtrl = (press.modifiers & GLFW_MOD_CONTROL) != 0;
    io.KeyShift = (press.modifiers & GLFW_MOD_SHIFT) != 0;
    io.KeyAlt = (press.modifiers & GLFW_MOD_ALT) != 0;
    replayed_key_ = press.key;
    return;
  }
}

void GlfwWindow::set_drop(std::function<void(const std::string& path)> drop) {
  drop_ = std::move(drop);
}

void GlfwWindow::poll_events() {
  glfwPollEvents();
}

bool GlfwWindow::wait_events(double seconds) {
  const Timer timer;
  glfwWaitEventsTimeout(seconds);
  return timer.seconds() < seconds;
}

void GlfwWindow::wake() {
  glfwPostEmptyEvent();
}

}  // namespace relume

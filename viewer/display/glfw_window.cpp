#include "viewer/display/glfw_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>

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

GlfwWindow::GlfwWindow(const std::string& title, ivec2 size) {
  if (!glfwInit()) {
    throw output_error("window", glfw_problem("there is no display"), offscreen_mend);
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(size.x, size.y, title.c_str(), nullptr, nullptr);
  if (window_ == nullptr) {
    const std::string problem = glfw_problem("it cannot be opened");
    glfwTerminate();
    throw output_error("window", problem, offscreen_mend);
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  glfwSetDropCallback(window_, [](GLFWwindow* handle, int count, const char** paths) {
    const auto* window = static_cast<const GlfwWindow*>(glfwGetWindowUserPointer(handle));
    for (int i = 0; i < count && window->drop_; ++i) window->drop_(paths[i]);
  });
}

GlfwWindow::~GlfwWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
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
}

void GlfwWindow::disconnect_input() {
  ImGui_ImplGlfw_Shutdown();
}

void GlfwWindow::begin_frame() {
  ImGui_ImplGlfw_NewFrame();
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

#pragma once

#include <deque>
#include <functional>
#include <string>

#include "viewer/display/surface.h"

struct GLFWwindow;

namespace relume {

/// True when a window could be opened here.
bool display_available();

/// A window. At most one at a time, on the main thread.
class GlfwWindow final : public EventSurface {
 public:
  /// `size` in screen units at 96 dpi. Throws Error(output) when there is no display or no
  /// OpenGL 3.3.
  GlfwWindow(const std::string& title, ivec2 size);
  ~GlfwWindow() override;
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;

  GlLoader loader() const override;
  ivec2 size_px() const override;
  void resize(ivec2 size_px) override;
  /// Opens another window in its place: a context stays with its window.
  void renew_context() override;
  void present() override;

  bool should_close() const override;
  bool is_context_lost() const override;
  void begin_frame() override;
  bool has_pending_keys() const override { return !presses_.empty() || replayed_key_ >= 0; }
  void poll_events() override;
  bool wait_events(double seconds) override;

  /// How much larger than at 96 dpi text has to be, > 0.
  float ui_scale() const;

  /// Connects mouse and keyboard to the current ImGui context until disconnect_input().
  void connect_input();
  void disconnect_input();
  /// `drop` is called, within poll_events() and wait_events(), with each file dropped on the
  /// window; empty: nobody is told.
  void set_drop(std::function<void(const std::string& path)> drop);

  /// Ends a wait_events(); may be called from any thread.
  static void wake();

 private:
  /// A key that went down, with the modifiers of that moment.
  struct KeyPress {
    int key = 0;
    int modifiers = 0;
  };

  GLFWwindow* create(ivec2 size) const;
  void open(ivec2 size);
  void close();
  void replay_key();

  std::string title_;
  GLFWwindow* window_ = nullptr;
  unsigned (*reset_status_)() = nullptr;  ///< glGetGraphicsResetStatus, where there is one
  bool has_input_ = false;                ///< connected to ImGui
  std::deque<KeyPress> presses_;          ///< since the last frame, oldest first
  int replayed_key_ = -1;
  std::function<void(const std::string& path)> drop_;
};

}  // namespace relume

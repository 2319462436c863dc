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
class GlfwWindow final : public Surface {
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
  void present() override;

  /// How much larger than at 96 dpi text has to be, > 0.
  float ui_scale() const;
  bool should_close() const;

  /// Connects mouse and keyboard to the current ImGui context until disconnect_input().
  void connect_input();
  void disconnect_input();
  /// Hands the input since the last frame to ImGui; before ImGui::NewFrame().
  void begin_frame();

  /// There are key presses that begin_frame() has not shown to ImGui yet.
  bool has_pending_keys() const { return !presses_.empty() || replayed_key_ >= 0; }

  /// `drop` is called, within poll_events() and wait_events(), with each file dropped on the
  /// window; empty: nobody is told.
  void set_drop(std::function<void(const std::string& path)> drop);

  /// Handles what has arrived, without waiting.
  void poll_events();
  /// Sleeps until something arrives; false when nothing did for `seconds`.
  bool wait_events(double seconds);
  /// Ends a wait_events(); may be called from any thread.
  static void wake();

 private:
  /// A key that went down, with the modifiers of that moment.
  struct KeyPress {
    int key = 0;
    int modifiers = 0;
  };

  void replay_key();

  GLFWwindow* window_ = nullptr;
  std::deque<KeyPress> presses_;  ///< since the last frame, oldest first
  int replayed_key_ = -1;
  std::function<void(const std::string& path)> drop_;
};

}  // namespace relume

#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/timer.h"
#include "viewer/display/osmesa_surface.h"
#include "viewer/display/screen.h"

namespace relume::test {

/// What one frame of the window's thread took, in milliseconds.
struct FrameTime {
  double wall_ms = 0;
  double processor_ms = 0;
  /// Ready to run while other threads and programs had the processors; 0 where the system does not
  /// tell (not Linux).
  double queued_ms = 0;
};

/// The viewer as its event loop drives it: input goes on while pictures are computed. Panels have a
/// window of 1280 x 800; the framebuffer is so small that drawing it in software takes next to no
/// time. From another thread than the one that made it nothing may be called.
class LiveWindow {
 public:
  /// Frames follow each other no faster than `frame_s`, as on a display.
  explicit LiveWindow(Workspace& workspace, double frame_s = 0);
  ~LiveWindow();
  LiveWindow(const LiveWindow&) = delete;
  LiveWindow& operator=(const LiveWindow&) = delete;

  /// Moves the pointer and draws.
  void point_at(vec2 position);
  void point_at(const std::string& item) { point_at(center(item)); }
  void press() { set_button(true); }
  void release() { set_button(false); }
  void click(const std::string& item);
  /// From the middle of `item` by `by`, in `moves` frames.
  void drag(const std::string& item, vec2 by, int moves);
  /// `code` as GLFW has it: a capital letter.
  void press_control(char code, bool shift = false);
  void type(const std::string& text);

  /// Draws one frame and notes what it took.
  void frame();
  /// Sleeps until there is something to take; false when there was nothing for `seconds`.
  bool wait_for_news(double seconds);

  bool has(const std::string& item) const { return screen_.ui().items.find(item).has_value(); }
  vec2 center(const std::string& item) const;
  const Screen& screen() const { return screen_; }
  std::vector<FrameTime>& times() { return times_; }

 private:
  void set_button(bool pressed);

  Workspace& workspace_;
  double frame_s_;
  Timer since_frame_;
  OsmesaSurface surface_;
  GlTable gl_;
  Screen screen_;
  vec2 pointer_{-1, -1};
  bool pressed_ = false;
  std::vector<FrameTime> times_;

  std::mutex mutex_;
  std::condition_variable wake_;
  bool has_news_ = false;  // guarded by mutex_
};

/// The value at a fraction in [0, 1] of the sorted values; 0 where there are none.
double percentile(std::vector<double> values, double fraction);

}  // namespace relume::test

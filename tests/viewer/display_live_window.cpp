#include "tests/viewer/display_live_window.h"

#include <fcntl.h>
#include <imgui.h>
#include <unistd.h>

#include <cstdio>
#include <ctime>
#include <thread>

#include "core/base/error.h"

namespace relume::test {
namespace {

constexpr ivec2 window_size{1280, 800};
constexpr int shrink = 16;  // window's pixels for each of the framebuffer, a side

double thread_processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// See proc_pid_schedstat(5): nanoseconds on a processor, then waiting for one.
double thread_queued_ms() {
  static thread_local const int file = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
  char text[128] = {};
  if (file < 0 || pread(file, text, sizeof text - 1, 0) <= 0) return 0;
  unsigned long long ran_ns = 0;
  unsigned long long queued_ns = 0;
  return std::sscanf(text, "%llu %llu", &ran_ns, &queued_ns) == 2
             ? 1e-6 * static_cast<double>(queued_ns)
             : 0;
}

}  // namespace

LiveWindow::LiveWindow(Workspace& workspace, double frame_s)
    : workspace_(workspace),
      frame_s_(frame_s),
      surface_(window_size / shrink),
      gl_(load_gl_table(surface_.loader())),
      screen_(workspace, gl_, {.scale = 1, .show_timings = true}) {
  ImGuiIO& io = ImGui::GetIO();
  for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
  workspace_.set_notify([this] {
    const std::lock_guard lock(mutex_);
    has_news_ = true;
    wake_.notify_one();
  });
}

LiveWindow::~LiveWindow() {
  workspace_.set_notify({});
}

void LiveWindow::frame() {
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = ImVec2(window_size.x, window_size.y);
  io.DisplayFramebufferScale = ImVec2(1.0f / shrink, 1.0f / shrink);
  io.DeltaTime = 1.0f / 60;
  io.MousePos = ImVec2(pointer_.x, pointer_.y);
  io.MouseDown[0] = pressed_;
  const double left_s = frame_s_ - since_frame_.seconds();
  if (left_s > 0) std::this_thread::sleep_for(std::chrono::duration<double>(left_s));
  since_frame_ = Timer();
  const Timer timer;
  const double processor_ms = thread_processor_ms();
  const double queued_ms = thread_queued_ms();
  screen_.draw(surface_.size_px());
  surface_.present();
  times_.push_back(
      {timer.ms(), thread_processor_ms() - processor_ms, thread_queued_ms() - queued_ms});
}

void LiveWindow::point_at(vec2 position) {
  pointer_ = position;
  frame();
}

void LiveWindow::set_button(bool pressed) {
  pressed_ = pressed;
  frame();
}

void LiveWindow::click(const std::string& item) {
  point_at(item);
  press();
  release();
  frame();
}

void LiveWindow::drag(const std::string& item, vec2 by, int moves) {
  const vec2 from = center(item);
  point_at(from);
  press();
  for (int i = 1; i <= moves; ++i) {
    point_at(from + by * (static_cast<float>(i) / static_cast<float>(moves)));
  }
  release();
  frame();
}

void LiveWindow::press_control(char code, bool shift) {
  ImGuiIO& io = ImGui::GetIO();
  io.KeyCtrl = true;
  io.KeyShift = shift;
  io.KeysDown[static_cast<int>(code)] = true;
  frame();
  io.KeysDown[static_cast<int>(code)] = false;
  io.KeyCtrl = io.KeyShift = false;
  frame();
}

void LiveWindow::type(const std::string& text) {
  ImGui::GetIO().AddInputCharactersUTF8(text.c_str());
  frame();
  frame();
}

bool LiveWindow::wait_for_news(double seconds) {
  std::unique_lock lock(mutex_);
  const bool arrived =
      wake_.wait_for(lock, std::chrono::duration<double>(seconds), [this] { return has_news_; });
  has_news_ = false;
  return arrived;
}

vec2 LiveWindow::center(const std::string& item) const {
  const auto rect = screen_.ui().items.find(item);
  if (!rect) throw input_error(item, "is not on the screen", screen_.ui().items.names());
  return glm::floor(rect->center());
}

double percentile(std::vector<double> values, double fraction) {
  if (values.empty()) return 0;
  const auto last = static_cast<double>(values.size() - 1);
  const auto place = values.begin() + static_cast<ptrdiff_t>(fraction * last + 0.5);
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

}  // namespace relume::test

#include "tests/viewer/display_soak.h"

#include <array>

#include "core/base/timer.h"
#include "viewer/commands/process_memory.h"

namespace relume::test {
namespace {

constexpr int edits_per_rest = 10;
constexpr double longest_rest_s = 1.5;

class Soak {
 public:
  Soak(LiveWindow& window, Workspace& workspace, const std::vector<std::string>& inputs,
       const std::filesystem::path& folder, int drag_moves)
      : drag_moves_(drag_moves),
        window_(window),
        workspace_(workspace),
        inputs_(inputs),
        folder_(folder) {}

  void edit(int number) {
    const int round = number / 2;
    if (number % 2 == 0) {
      // Out, and back the next time.
      window_.drag("handle.1", vec2(90, -50) * (round % 2 == 0 ? 1.0f : -1.0f), drag_moves_);
    } else {
      other_edit(round);
    }
    if (number % edits_per_rest == edits_per_rest - 1) rest(longest_rest_s);
  }

  /// Frames as the event loop draws them, until nothing is left to come or the time is over.
  void rest(double seconds) {
    const Timer timer;
    do {
      window_.wait_for_news(0.02);
      window_.frame();
    } while (is_working() && timer.seconds() < seconds);
  }

  /// What is allocated when nothing goes on.
  double settled_bytes() {
    workspace_.wait(true);
    rest(longest_rest_s);
    workspace_.wait(true);
    return static_cast<double>(allocated_bytes());
  }

  void open_next(int number) {
    if (inputs_.empty()) return;
    const uint64_t before = workspace_.session_number();
    workspace_.open(inputs_[static_cast<size_t>(number) % inputs_.size()]);
    const Timer timer;
    while (workspace_.session_number() == before && timer.seconds() < 60) rest(0.05);
    rest(longest_rest_s);
  }

  /// Has enough frames, references and maps finished for all their buffers to be in use, which
  /// drags that replace them may never come to: else their first use would look like growth.
  void use_all_buffers() {
    for (const char* key : {"v", "f"}) {
      window_.type(key);
      for (const char* gain : {".", ",", ".", ","}) {
        window_.type(gain);
        workspace_.wait(true);
        window_.frame();
      }
    }
  }

 private:
  void other_edit(int round) {
    const float sign = (round / 8) % 2 == 0 ? 1.0f : -1.0f;
    switch (round % 8) {
      case 0:
        return window_.drag("light.gain", vec2(40 * sign, 0), drag_moves_);
      case 1:
        window_.press_control('Z');
        return window_.press_control('Z', true);
      case 2:
        return look_at_maps();
      case 3:
        return window_.drag("view.exposure", vec2(20 * sign, 0), drag_moves_);
      case 4:
        window_.type("a");
        window_.drag("handle.1", vec2(30, 20), drag_moves_);
        window_.press_control('Z');
        return window_.press_control('Z');
      case 5:
        window_.click("shadows.none");
        return window_.click("shadows.ray");
      case 6:
        workspace_.save(folder_ / "soak.json");
        return window_.frame();
      case 7:
        workspace_.export_frame(folder_ / "soak.exr");
        return window_.frame();
    }
  }

  void look_at_maps() {
    for (const char* key : {"k", "t", "n", "v", "h", "l", "l", "f"}) {
      window_.type(key);
      window_.wait_for_news(0.02);
      window_.frame();
    }
  }

  bool is_working() const {
    const Session* session = workspace_.session();
    return workspace_.load_status().opening || workspace_.is_exporting() || session == nullptr ||
           session->status().busy || session->status().outdated;
  }

  int drag_moves_;
  LiveWindow& window_;
  Workspace& workspace_;
  const std::vector<std::string>& inputs_;
  const std::filesystem::path& folder_;
};

}  // namespace

SoakFigures soak(LiveWindow& window, Workspace& workspace, const std::vector<std::string>& inputs,
                 const std::filesystem::path& folder, const SoakParams& params) {
  Soak person(window, workspace, inputs, folder, params.drag_moves);
  SoakFigures figures;
  person.rest(longest_rest_s);
  const Timer timer;
  for (int cycle = 0;; ++cycle) {
    const double part = params.seconds > 0 ? timer.seconds() / params.seconds
                                           : static_cast<double>(cycle) / params.cycles;
    if (part >= 1) break;
    if (part >= 1.0 / 3 && part < 2.0 / 3) person.open_next(cycle);
    for (int i = 0; i < edits_per_cycle; ++i) person.edit(figures.edits++);
    if (cycle + 1 < params.warm_up_cycles) continue;
    if (cycle + 1 == params.warm_up_cycles) person.use_all_buffers();
    figures.last_bytes = person.settled_bytes();
    if (cycle + 1 == params.warm_up_cycles) figures.first_bytes = figures.last_bytes;
    if (params.report) params.report(figures);
  }
  person.use_all_buffers();
  figures.last_bytes = person.settled_bytes();
  return figures;
}

}  // namespace relume::test

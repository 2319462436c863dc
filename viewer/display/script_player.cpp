#include "viewer/display/script_player.h"

#include <fmt/format.h>
#include <imgui.h>

#include <map>

#include "core/base/error.h"
#include "core/image/image_io.h"

namespace relume {
namespace {

constexpr float time_step_s = 1.0f / 60;
constexpr int settle_frames = 3;  // ImGui needs two frames to lay out what changed
constexpr int drag_moves = 4;

const std::map<std::string, ImGuiKey, std::less<>> named_keys = {
    {"enter", ImGuiKey_Enter},       {"escape", ImGuiKey_Escape},
    {"tab", ImGuiKey_Tab},           {"backspace", ImGuiKey_Backspace},
    {"delete", ImGuiKey_Delete},     {"left", ImGuiKey_LeftArrow},
    {"right", ImGuiKey_RightArrow},  {"up", ImGuiKey_UpArrow},
    {"down", ImGuiKey_DownArrow},    {"page-up", ImGuiKey_PageUp},
    {"page-down", ImGuiKey_PageDown}};

class Player {
 public:
  Player(Workspace& workspace, Screen& screen, const GlTable& gl, Surface& surface,
         std::filesystem::path folder)
      : workspace_(workspace),
        screen_(screen),
        gl_(gl),
        surface_(surface),
        folder_(std::move(folder)),
        io_(ImGui::GetIO()) {
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io_.KeyMap[key] = key;
    // Letters have the codes that GLFW gives them.
    for (const auto& [key, letter] :
         {std::pair(ImGuiKey_A, 'A'), std::pair(ImGuiKey_C, 'C'), std::pair(ImGuiKey_V, 'V'),
          std::pair(ImGuiKey_X, 'X'), std::pair(ImGuiKey_Y, 'Y'), std::pair(ImGuiKey_Z, 'Z')}) {
      io_.KeyMap[key] = letter;
    }
  }

  void play(const Script& script) {
    settle();
    for (const ScriptStep& step : script.steps) {
      if (screen_.quit()) return;
      play(step);
    }
  }

 private:
  void frame() {
    const ivec2 size = surface_.size_px();
    io_.DisplaySize = ImVec2(static_cast<float>(size.x), static_cast<float>(size.y));
    io_.DisplayFramebufferScale = ImVec2(1, 1);
    io_.DeltaTime = time_step_s;
    io_.MousePos = ImVec2(pointer_.x, pointer_.y);
    io_.MouseDown[0] = pressed_;
    screen_.draw(size);
    io_.MouseWheel = 0;
    workspace_.wait(screen_.resting());
    require_no_gl_error(gl_, "drawing");
    surface_.present();
  }

  void settle() {
    for (int i = 0; i < settle_frames; ++i) frame();
  }

  vec2 target(const ScriptStep& step) const {
    if (step.item.empty()) return step.position;
    const auto rect = screen_.ui().items.find(step.item);
    if (!rect) {
      throw input_error(step.place, fmt::format("there is no item '{}' on the screen", step.item),
                        "use one of: " + screen_.ui().items.names());
    }
    return glm::floor(rect->center());
  }

  void point_at(vec2 position) {
    pointer_ = position;
    frame();
  }

  void set_button(bool pressed) {
    pressed_ = pressed;
    frame();
  }

  void drag(vec2 from, vec2 by) {
    point_at(from);
    set_button(true);
    for (int i = 1; i <= drag_moves; ++i) {
      point_at(from + by * (static_cast<float>(i) / static_cast<float>(drag_moves)));
    }
    set_button(false);
    settle();
  }

  /// "ctrl+shift+z", "delete", "left" or one character to type.
  void press_key(const ScriptStep& step) {
    std::string name = step.text;
    const auto take_prefix = [&name](const std::string& prefix) {
      const bool has = name.starts_with(prefix) && name.size() > prefix.size();
      if (has) name.erase(0, prefix.size());
      return has;
    };
    io_.KeyCtrl = take_prefix("ctrl+");
    io_.KeyShift = take_prefix("shift+");
    const auto named = named_keys.find(name);
    const bool is_letter = io_.KeyCtrl && name.size() == 1 && name[0] >= 'a' && name[0] <= 'z';
    if (named == named_keys.end() && !is_letter) {
      if (step.text.size() != 1) {
        throw input_error(step.place, fmt::format("there is no key '{}'", step.text),
                          "use one character, ctrl+ and a letter, or one of: " + key_names());
      }
      type_text(step.text);
      return;
    }
    const int key = is_letter ? name[0] - 'a' + 'A' : named->second;
    io_.KeysDown[key] = true;
    frame();
    io_.KeysDown[key] = false;
    io_.KeyCtrl = false;
    io_.KeyShift = false;
    settle();
  }

  static std::string key_names() {
    std::string names;
    for (const auto& [name, key] : named_keys) names += (names.empty() ? "" : ", ") + name;
    return names;
  }

  void drop(const std::string& path) {
    workspace_.open(path);
    settle();
  }

  void type_text(const std::string& text) {
    io_.AddInputCharactersUTF8(text.c_str());
    settle();
  }

  void resize(vec2 size) {
    surface_.resize(ivec2(size));
    settle();
  }

  void screenshot(const std::string& file) {
    settle();
    const ivec2 size = surface_.size_px();
    screen_.draw(size);
    write_png(folder_ / file, read_framebuffer(gl_, size));
    surface_.present();
  }

  void play(const ScriptStep& step) {
    switch (step.kind) {
      case StepKind::move:
        return point_at(target(step));
      case StepKind::move_by:
        return point_at(pointer_ + step.position);
      case StepKind::press:
        return set_button(true);
      case StepKind::release:
        return set_button(false);
      case StepKind::click:
        point_at(target(step));
        set_button(true);
        set_button(false);
        return settle();
      case StepKind::drag:
        return drag(target(step), step.position);
      case StepKind::wheel:
        io_.MouseWheel = step.position.x;
        return settle();
      case StepKind::key:
        return press_key(step);
      case StepKind::type:
        return type_text(step.text);
      case StepKind::drop:
        return drop(step.text);
      case StepKind::wait:
        return settle();
      case StepKind::resize:
        return resize(step.position);
      case StepKind::renew_context:
        screen_.renew_context(surface_);
        return settle();
      case StepKind::screenshot:
        return screenshot(step.text);
    }
  }

  Workspace& workspace_;
  Screen& screen_;
  const GlTable& gl_;
  Surface& surface_;
  std::filesystem::path folder_;
  ImGuiIO& io_;
  vec2 pointer_{-1, -1};
  bool pressed_ = false;
};

}  // namespace

void play_script(const Script& script, Workspace& workspace, Screen& screen, const GlTable& gl,
                 Surface& surface, const std::filesystem::path& folder) {
  Player(workspace, screen, gl, surface, folder).play(script);
}

DisplayImage read_framebuffer(const GlTable& gl, ivec2 size_px) {
  DisplayImage image{.width = size_px.x, .height = size_px.y, .channels = 3, .pixels = {}};
  const size_t row = 3 * static_cast<size_t>(size_px.x);
  std::vector<uint8_t> bottom_up(row * size_px.y);
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, size_px.x, size_px.y, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data());
  image.pixels.reserve(bottom_up.size());
  for (int y = size_px.y - 1; y >= 0; --y) {
    const auto first = bottom_up.begin() + static_cast<ptrdiff_t>(row) * y;
    image.pixels.insert(image.pixels.end(), first, first + static_cast<ptrdiff_t>(row));
  }
  return image;
}

}  // namespace relume

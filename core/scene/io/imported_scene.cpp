#include "core/scene/io/imported_scene.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/scene/io/json_node.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr std::string_view fitted_camera =
    R"({"fit": true, "direction": [-0.5, -0.35, -0.8], "fov_y_deg": 35, "margin": 1.1})";

constexpr std::string_view own_lights = R"([
    {"name": "key", "position": {"relative": [2, 2.5, 1.5]}, "gain_relative": 40},
    {"name": "fill", "position": {"relative": [-2.5, 1, 2.5]}, "gain_relative": 10},
    {"name": "rim", "position": {"relative": [-2.5, 1.5, -2]}, "gain_relative": 20}
  ])";

std::string camera_text(const std::optional<Camera>& camera) {
  if (!camera) return std::string(fitted_camera);
  return fmt::format(R"({{"eye": {}, "target": {}, "up": {}, "fov_y_deg": {}}})",
                     json_vector(camera->eye), json_vector(camera->target), json_vector(camera->up),
                     json_number(camera->fov_y_deg));
}

std::string light_list(const std::vector<Light>& lights) {
  if (lights.empty()) return std::string(own_lights);
  const std::string text = format_lights(lights);
  const size_t first = text.find('[');
  return text.substr(first, text.rfind(']') + 1 - first);
}

}  // namespace

std::string imported_scene_text(const std::filesystem::path& path, const ImportedView& view) {
  return fmt::format(
      "{{\n  \"name\": {},\n  \"image\": {{\"width\": {}, \"height\": {}}},\n  \"camera\": {},\n"
      "  \"geometry\": [{{\"file\": {}}}],\n  \"lights\": {}\n}}\n",
      json_quoted(printable(path.stem().string(), max_name_length)), view.width, view.height,
      camera_text(view.camera), json_quoted(path.filename().string()), light_list(view.lights));
}

}  // namespace relume

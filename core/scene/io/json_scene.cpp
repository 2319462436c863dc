#include <fmt/format.h>

#include "core/base/file.h"
#include "core/scene/io/builtin_scenes.h"
#include "core/scene/io/gltf.h"
#include "core/scene/io/json_geometry.h"
#include "core/scene/io/json_lights.h"
#include "core/scene/io/json_materials.h"
#include "core/scene/io/json_node.h"
#include "core/scene/io/load_scene.h"
#include "core/scene/io/pbrt.h"
#include "core/scene/limits.h"

namespace relume {
namespace {

constexpr uint64_t max_scene_file_bytes = uint64_t{64} << 20;

/// The bounds that the camera fits and relative lights refer to.
Bounds focus_bounds(const JsonNode& root, const Scene& scene) {
  const auto focus = root.find("focus");
  if (!focus) return world_bounds(scene);
  std::vector<Bounds> local;
  for (const Prototype& prototype : scene.prototypes) local.push_back(local_bounds(prototype));
  Bounds bounds;
  for (const JsonNode& item : focus->items(scene.prototypes.size() + 1)) {
    const std::string name = item.text(max_name_length);
    bool placed = false;
    for (const Instance& instance : scene.instances) {
      const std::string& prototype = scene.prototypes[instance.prototype].name;
      if (prototype != name && !prototype.starts_with(name + "/")) continue;
      bounds.extend(transform_bounds(local[instance.prototype], instance.world_from_local));
      placed = true;
    }
    if (!placed) {
      throw item.error(fmt::format("\"{}\" is no geometry placed in the scene", name),
                       "give the name of an entry of \"geometry\"");
    }
  }
  if (bounds.empty()) throw focus->error("is empty", "name some geometry");
  return bounds;
}

/// The distance from the middle of `bounds` at which a camera that looks along `rays.forward()`
/// sees all of its corners.
float fit_distance(const Bounds& bounds, const CameraRays& rays, float tan_x, float tan_y) {
  float distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const vec3 p((corner & 1) != 0 ? bounds.high.x : bounds.low.x,
                 (corner & 2) != 0 ? bounds.high.y : bounds.low.y,
                 (corner & 4) != 0 ? bounds.high.z : bounds.low.z);
    const vec3 v = p - bounds.center();
    const float side = std::max(std::abs(glm::dot(v, rays.right())) / tan_x,
                                std::abs(glm::dot(v, rays.up())) / tan_y);
    distance = std::max(distance, side - glm::dot(v, rays.forward()));
  }
  return distance;
}

Camera fit_camera(const JsonNode& node, const Bounds& bounds, int width, int height) {
  Camera camera;
  vec3 direction(0, 0, -1);
  float margin = 1.1f;
  node.read("direction", direction, -max_coordinate, max_coordinate);
  node.read("up", camera.up, -max_coordinate, max_coordinate);
  node.read("fov_y_deg", camera.fov_y_deg, 0.01f, 178);
  node.read("margin", margin, 0.01f, 100);
  const vec3 forward = normalize_or(direction, vec3(0));
  if (forward == vec3(0))
    throw node.error("its direction is zero", "give the way the camera looks");
  camera.eye = vec3(0);
  camera.target = forward;
  const CameraRays rays(camera, width, height);
  const float tan_y = std::tan(0.5f * radians_from_degrees(camera.fov_y_deg));
  const float tan_x = tan_y * static_cast<float>(width) / static_cast<float>(height);
  const float distance = margin * fit_distance(bounds, rays, tan_x, tan_y);
  camera.target = bounds.center();
  camera.eye = camera.target - forward * distance;
  return camera;
}

Camera read_camera(const JsonNode& node, const Bounds& bounds, int width, int height) {
  bool fit = false;
  if (node.is_object()) node.read("fit", fit);
  if (fit) {
    node.expect_keys({"fit", "direction", "margin", "up", "fov_y_deg"});
    return fit_camera(node, bounds, width, height);
  }
  node.expect_keys({"fit", "eye", "target", "up", "fov_y_deg"});
  Camera camera;
  const char* mend = "give three numbers, or let \"fit\": true find it";
  camera.eye = node.get("eye", mend).vector(-max_coordinate, max_coordinate);
  camera.target = node.get("target", mend).vector(-max_coordinate, max_coordinate);
  node.read("up", camera.up, -max_coordinate, max_coordinate);
  node.read("fov_y_deg", camera.fov_y_deg, 0.01f, 178);
  return camera;
}

int read_side(const JsonNode& image, std::string_view key) {
  const JsonNode node = image.get(key, "give the number of pixels");
  return static_cast<int>(node.count(1, static_cast<uint64_t>(max_image_side)));
}

void read_settings(const JsonNode& root, Scene& scene) {
  root.read("name", scene.name, max_name_length);
  if (const auto image = root.find("image")) {
    image->expect_keys({"width", "height"});
    scene.width = read_side(*image, "width");
    scene.height = read_side(*image, "height");
  }
  root.read("instancing", scene.instancing, instancing_labels);
  root.read("exposure", scene.exposure, -64, 64);
}

void read_lighting(const JsonNode& root, const SceneFrame& frame, Scene& scene) {
  scene.lights = read_lights(root.get("lights", "give \"lights\": [ ... ]"), frame);
  const auto representatives = root.find("representative_lights");
  std::tie(scene.representative_low, scene.representative_high) =
      representatives ? read_representatives(*representatives, frame)
                      : default_representatives(frame);
}

/// `place` stands in messages; `folder` resolves relative paths.
Scene parse(const std::string& text, const std::string& place, const std::filesystem::path& folder,
            std::span<const ShaderInfo* const> shaders, const ProgressCallback& progress) {
  const JsonDocument document(text, place);
  const JsonNode root = document.root();
  root.expect_keys({"$schema", "name", "image", "camera", "focus", "materials", "geometry",
                    "lights", "representative_lights", "instancing", "exposure"});
  Scene scene;
  scene.text = text;
  scene.shaders.assign(shaders.begin(), shaders.end());
  read_settings(root, scene);
  MaterialNames materials;
  if (const auto list = root.find("materials")) materials = read_materials(*list, folder, scene);
  const JsonNode geometry = root.get("geometry", "give \"geometry\": [ ... ]");
  read_geometry(geometry, folder, materials, scene, progress);
  if (scene.instances.empty()) {
    throw geometry.error("places nothing in the scene",
                         "add an entry that is not only a prototype");
  }
  const Bounds bounds = focus_bounds(root, scene);
  scene.camera = read_camera(root.get("camera", "give eye and target, or \"fit\": true"), bounds,
                             scene.width, scene.height);
  read_lighting(root, {bounds.center(), bounds.radius()}, scene);
  return scene;
}

const BuiltinScene* find_builtin(const std::string& name) {
  for (const BuiltinScene& scene : builtin_scenes()) {
    if (scene.name == name) return &scene;
  }
  return nullptr;
}

}  // namespace

Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  std::span<const ShaderInfo* const> shaders, const ProgressCallback& progress) {
  const std::string place = file.empty() ? "built-in scene" : file.string();
  Scene scene = parse(text, place, file.parent_path(), shaders, progress);
  if (!file.empty()) scene.file = std::filesystem::absolute(file).lexically_normal();
  if (scene.name.empty()) scene.name = file.empty() ? "scene" : file.stem().string();
  validate_scene(scene);
  return scene;
}

Scene load_scene(const std::string& name_or_path, std::span<const ShaderInfo* const> shaders,
                 const ProgressCallback& progress) {
  if (const BuiltinScene* builtin = find_builtin(name_or_path)) {
    return parse_scene(std::string(builtin->text), {}, shaders, progress);
  }
  const std::filesystem::path file(name_or_path);
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) {
    std::string names;
    for (const std::string& name : builtin_scene_names()) names += ", " + name;
    throw input_error(name_or_path, "is neither a scene file nor a built-in scene",
                      "check the path, or name one of: " + names.substr(2));
  }
  if (is_gltf_path(file)) {
    // The text names the file beside it, as any scene file would.
    return parse_scene(gltf_scene_text(file), file, shaders, progress);
  }
  if (is_pbrt_path(file)) return parse_scene(pbrt_scene_text(file), file, shaders, progress);
  const std::string extension = file.extension().string();
  if (extension == ".obj" || extension == ".ply" || extension == ".hair") {
    throw input_error(name_or_path, "is geometry alone, without a camera and lights",
                      "name it in a scene file: docs/scene-format.md");
  }
  if (extension == ".exr" || extension == ".png" || extension == ".jpg") {
    throw input_error(
        name_or_path, "is an image, no scene",
        "name a scene file or a cache; samples of another renderer: docs/aov-input.md");
  }
  return parse_scene(read_text_file(file, max_scene_file_bytes), file, shaders, progress);
}

std::vector<std::string> builtin_scene_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.emplace_back(scene.name);
  return names;
}

}  // namespace relume

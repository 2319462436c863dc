#include "core/scene/io/imported_material.h"

#include <fmt/format.h>

#include <set>

#include "core/base/error.h"
#include "core/scene/limits.h"

namespace relume {

int find_shader(const Scene& scene, std::string_view name, const std::string& file) {
  for (size_t i = 0; i < scene.shaders.size(); ++i) {
    if (scene.shaders[i]->name == name) return static_cast<int>(i);
  }
  throw input_error(file, "the program lacks a shader for its materials",
                    fmt::format("add {} to the shader table", name));
}

bool is_leaf(const MaterialOptions& options, const std::string& name) {
  return std::ranges::find(options.leaf_materials, name) != options.leaf_materials.end();
}

void check_leaf_materials(const MaterialOptions& options, std::span<const std::string> known,
                          const std::string& file) {
  const std::set<std::string> names(known.begin(), known.end());
  for (const std::string& leaf : options.leaf_materials) {
    if (names.contains(leaf)) continue;
    std::string list;
    for (const std::string& name : names) list += name.empty() ? "" : " \"" + name + "\"";
    throw input_error(file, fmt::format("leaf material \"{}\" is not in it", leaf),
                      "the file uses:" + list);
  }
}

void make_leaf(const Scene& scene, const MaterialOptions& options, vec3 color, int texture,
               const std::string& file, Material& material) {
  material.shader = find_shader(scene, "leaf", file);
  material.parameters.push_back({"diffuse", color, texture});
  material.parameters.push_back({"transmit", color * options.leaf_transmission, texture});
}

uint32_t add_material(Scene& scene, Material material, const std::string& file) {
  if (scene.materials.size() >= max_materials) {
    throw limit_error(file, "too many materials", fmt::format("the limit is {}", max_materials));
  }
  scene.materials.push_back(std::move(material));
  return static_cast<uint32_t>(scene.materials.size() - 1);
}

void print_import_note(const std::string& file, std::string_view note) {
  fmt::print(stderr, "{}: {}\n", file, printable(note, 1000));
}

}  // namespace relume

#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/scene/scene.h"

namespace relume {

// How the materials of other programs' files become ours: what their readers share.

/// What a scene file says about the materials of a file that it names.
struct MaterialOptions {
  std::vector<std::string> leaf_materials;  ///< names that become two-sided translucent leaves
  float leaf_transmission = 0.5f;           ///< transmit = this times the diffuse colour
  int material_override = -1;               ///< index into Scene::materials used for all, or -1
};

/// The index of the shader `name` in scene.shaders. Throws Error(input) naming `file` where the
/// program lacks it.
int find_shader(const Scene& scene, std::string_view name, const std::string& file);

/// True when `name` is to become a leaf.
bool is_leaf(const MaterialOptions& options, const std::string& name);

/// Throws Error(input) when a leaf material is none of the `known` names of `file`.
void check_leaf_materials(const MaterialOptions& options, std::span<const std::string> known,
                          const std::string& file);

/// Makes `material` a leaf of this colour, times the texture unless that is -1.
void make_leaf(const Scene& scene, const MaterialOptions& options, vec3 color, int texture,
               const std::string& file, Material& material);

/// Adds a material; returns its index. Throws Error(limit) above max_materials.
uint32_t add_material(Scene& scene, Material material, const std::string& file);

/// Tells the user in one line, on stderr, what of `file` is read differently or not at all.
void print_import_note(const std::string& file, std::string_view note);

}  // namespace relume

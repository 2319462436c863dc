#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/io/imported_material.h"

namespace relume {

/// True for the extension .pbrt.
bool is_pbrt_path(const std::filesystem::path& path);

/// Reads a pbrt-v3 or pbrt-v4 scene and adds its materials, textures and shapes to `scene`: all
/// that stands alone as one prototype, and one for each object that is placed. Returns where they
/// are placed. What is read differently or not at all is told on stderr, each kind once. pbrt's
/// axes are left-handed: where the file's camera sees them so, x changes sign. Throws Error(input)
/// or Error(limit) as "FILE:LINE: ...".
std::vector<Instance> load_pbrt(const std::filesystem::path& path, const MaterialOptions& options,
                                Scene& scene);

/// A scene file's text (docs/scene-format.md) that shows a pbrt scene with its perspective camera,
/// film and point, spot and distant lights.
std::string pbrt_scene_text(const std::filesystem::path& path);

}  // namespace relume

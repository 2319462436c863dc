#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/base/progress.h"
#include "core/scene/scene.h"

namespace relume {

/// The label of a built-in scene ("hair", "plants", "spheres") or the path of a scene file
/// (docs/scene-format.md). `shaders` is the table of core/shade/shaders.h: materials are checked
/// against it. Throws Error(input) naming file and field or line, or Error(limit).
Scene load_scene(const std::string& name_or_path, std::span<const ShaderInfo* const> shaders,
                 const ProgressCallback& progress = {});

/// The same for a scene's text; `file` is used in messages and its folder resolves relative paths.
Scene parse_scene(const std::string& text, const std::filesystem::path& file,
                  std::span<const ShaderInfo* const> shaders,
                  const ProgressCallback& progress = {});

/// Labels of the built-in scenes.
std::vector<std::string> builtin_scene_names();

/// Lights as a JSON text in the scene file's own form ({"lights": [...]}), and back. `place` is the
/// file named in messages. parse_lights accepts a light file or a whole scene file.
std::string format_lights(const std::vector<Light>& lights);
std::vector<Light> parse_lights(const std::string& text, const std::string& place);

}  // namespace relume

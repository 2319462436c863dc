#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera.h"
#include "core/scene/light.h"

namespace relume {

/// What a file of another program shows besides geometry.
struct ImportedView {
  std::optional<Camera> camera;  ///< nothing: one that sees it all
  int width = 512;               ///< pixels
  int height = 512;
  std::vector<Light> lights;  ///< none: three of our own
};

/// A scene file's text (docs/scene-format.md) that shows the file at `path`, which stands beside
/// it.
std::string imported_scene_text(const std::filesystem::path& path, const ImportedView& view);

}  // namespace relume

#pragma once

#include <filesystem>

#include "core/scene/scene.h"

namespace relume {

struct HairOptions {
  uint32_t material = 0;      ///< index into Scene::materials for all strands
  float thickness_scale = 1;  ///< multiplies the file's thickness
  bool use_colors = true;     ///< per-strand colour (mean of the points') from the file
};

/// Reads a Cem Yuksel HAIR file (128-byte header and arrays). The file's thickness is a strand's
/// diameter. Counts are checked against the file's size before anything is allocated. Zero-length
/// segments and strands of fewer than two points are dropped (counted). Throws Error(input) naming
/// file and byte offset, or Error(limit).
Curves load_hair(const std::filesystem::path& path, const HairOptions& options);

}  // namespace relume

#pragma once

#include <filesystem>
#include <span>

#include "core/scene/scene.h"

namespace relume {

/// The index in scene.textures of the image at `path`, decoded once per (path, srgb, color_space).
/// A colour space of $OCIO, where given, takes the colours to scene-linear; `srgb` is then true.
/// Throws Error(input) when it is missing or corrupt (`place` names who refers to it) and
/// Error(limit) above 16384 x 16384. Declared here, defined in core/image/image_io.cpp.
int add_texture(Scene& scene, const std::filesystem::path& path, bool srgb,
                const std::string& place, const std::string& color_space = "");

/// The same for the bytes of a PNG or JPEG file inside another file. `name` becomes the texture's.
int add_texture(Scene& scene, std::span<const std::byte> bytes, const std::string& name, bool srgb,
                const std::string& place);

}  // namespace relume

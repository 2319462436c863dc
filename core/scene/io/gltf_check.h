#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace relume {

/// True when `bytes` start as a GLB does.
bool is_binary_gltf(std::span<const std::byte> bytes);

/// Everything that can be told of a .gltf or .glb from its container and JSON alone, before a
/// library sees the file: sizes, depth, counts, version and required extensions. Throws
/// Error(input) or Error(limit) that names `file` and the place in it.
void check_gltf(std::span<const std::byte> bytes, const std::string& file);

}  // namespace relume

#pragma once

#include <filesystem>
#include <optional>

#include "core/base/progress.h"
#include "core/scene/io/json_materials.h"
#include "core/scene/io/json_node.h"
#include "core/scene/scene.h"

namespace relume {

/// Reads a scene file's "geometry": adds prototypes and instances to `scene`, whose materials are
/// complete. OBJ files add materials and textures of their own.
void read_geometry(const JsonNode& list, const std::filesystem::path& folder,
                   const MaterialNames& materials, Scene& scene, const ProgressCallback& progress);

/// {"translate": [x, y, z], "rotate_deg": [x, y, z], "scale": s | [x, y, z]}: scales first, then
/// rotates about x, y and z in this order, then translates.
mat4x3 read_transform(const JsonNode& node);

/// The prototype that a generator entry describes; nothing for plant-field, which adds its own
/// prototypes and instances to `scene`. `extra_keys` are those that the caller reads.
std::optional<Prototype> read_generator(const JsonNode& node, const MaterialNames& materials,
                                        const std::vector<std::string_view>& extra_keys,
                                        Scene& scene);

}  // namespace relume

#pragma once

#include <span>

#include "core/scene/shader_info.h"

namespace relume {

/// Every shader of the program, in a fixed order: lambert, phong, kajiya-kay, leaf, ggx. Scene
/// loaders, caches and the viewer are given this table.
std::span<const ShaderInfo* const> shader_table();

}  // namespace relume

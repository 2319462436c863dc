#pragma once

#include "core/scene/scene.h"

namespace relume {

/// True when any texel of `texture` is less than fully opaque.
bool has_transparency(const Texture& texture);

/// Makes scene.textures[texture] the cut-out mask of `material`: its alpha channel where that says
/// anything, its luminance otherwise (a grey mask image).
void set_alpha_mask(const Scene& scene, int texture, Material& material);

}  // namespace relume

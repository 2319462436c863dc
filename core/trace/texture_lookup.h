#pragma once

#include "core/scene/scene.h"

namespace relume {

/// Bilinear look-up, repeating in both directions; v = 0 is the bottom row. RGB is decoded from
/// sRGB to linear when the texture says so; alpha is linear. A non-finite uv reads as (0, 0).
vec4 lookup_texture(const Texture& texture, vec2 uv);

}  // namespace relume

#pragma once

#include <string>
#include <vector>

#include "core/scene/light_animation.h"

namespace relume {

/// The animations of the lights in a light file or a scene file (docs/scene-format.md,
/// "Animation"), in the order of its lights; empty where the text has no lights. Throws
/// Error(input) naming the field in `place`.
std::vector<LightAnimation> parse_light_animations(const std::string& text,
                                                   const std::string& place);

}  // namespace relume

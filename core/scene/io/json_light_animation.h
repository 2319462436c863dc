#pragma once

#include "core/scene/io/json_node.h"
#include "core/scene/light_animation.h"

namespace relume {

inline constexpr float max_light_gain = 1e20f;

/// The "keyframes" and the "turntable" of a light; not set where it has neither.
LightAnimation read_light_animation(const JsonNode& light);

}  // namespace relume

#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "core/scene/io/json_node.h"
#include "core/scene/light.h"

namespace relume {

/// What relative positions and gains refer to: the middle and the radius (half the diagonal) of the
/// scene's bounds, or of the geometry named by "focus".
struct SceneFrame {
  vec3 center{0};
  float radius = 1;  ///< > 0
};

/// A position: [x, y, z], or {"relative": [x, y, z]} = center + radius * (x, y, z). Without a frame
/// the second form is an error.
vec3 read_position(const JsonNode& node, const std::optional<SceneFrame>& frame);

/// The lights of a list, with unique names.
std::vector<Light> read_lights(const JsonNode& list, const std::optional<SceneFrame>& frame);

/// The two lights of "representative_lights".
std::pair<Light, Light> read_representatives(const JsonNode& list, const SceneFrame& frame);

/// Used when a scene names none: two point lights that bound a box above the frame's sphere.
std::pair<Light, Light> default_representatives(const SceneFrame& frame);

}  // namespace relume

#pragma once

#include <optional>
#include <span>

#include "core/math/vec.h"
#include "core/scene/camera.h"

namespace relume {

/// A world position and where the picture shows it; pixels from the top left corner.
struct SeenPoint {
  vec3 position;
  vec2 film_px;
};

/// The camera, with square pixels and the view axis in the middle of the picture, that sees the
/// points where they are: least squares over the directions in the picture (Tsai's radial
/// alignment), then over depth. Nothing where the points do not tell, as when they lie in a plane
/// or are fewer than 16.
std::optional<Camera> fit_camera(std::span<const SeenPoint> points, int width, int height);

}  // namespace relume

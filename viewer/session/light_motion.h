#pragma once

#include "core/math/vec.h"
#include "core/scene/camera.h"
#include "core/scene/light.h"

namespace relume {

/// Where a light is taken hold of, world. Point and spot: its position. Directional: on the sphere
/// around `bounds`, where the light comes from.
vec3 light_handle(const Light& light, const Bounds& bounds);

/// Moves the light so that its handle is at `p_world` (a directional light: in that direction). A
/// position that is not finite, or that leaves a directional light without direction, is ignored.
void set_light_handle(Light& light, const Bounds& bounds, vec3 p_world);

/// `p_world` moved parallel to the film, at its own depth, by `delta_px` of film. Points at or
/// behind the eye do not move.
vec3 move_in_view_plane(const CameraRays& rays, vec3 p_world, vec2 delta_px);

/// `p_world` moved along the unit vector `axis` by as much as `delta_px` of film shows of it.
/// Nothing moves when the axis points (almost) at the eye, below a pixel per `unit` of its length.
vec3 move_along_axis(const CameraRays& rays, vec3 p_world, vec3 axis, float unit, vec2 delta_px);

/// How far a press of an arrow key moves a light at `p_world`: `motion` to the right, down and away
/// from the eye, in film pixels at the light's depth, or at that of the camera's target where the
/// light is behind the eye.
vec3 move_as_target(const CameraRays& rays, const Camera& camera, vec3 p_world, vec3 motion);

}  // namespace relume

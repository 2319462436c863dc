#pragma once

#include "core/math/vec.h"
#include "core/scene/light.h"

namespace relume {

/// A disc across a spot's axis on which its cones are drawn and dragged.
struct SpotCone {
  vec3 apex{0};         ///< world
  vec3 axis{0, -1, 0};  ///< unit, the way the light travels
  vec3 right{1, 0, 0};  ///< unit, across
  vec3 up{0, 0, 1};     ///< unit, across
  float distance = 1;   ///< from the apex to the disc, world, > 0
};

/// The disc at `aim_distance` from the light, or nearer where the outer cone would be wider than
/// half the scene's radius.
SpotCone make_spot_cone(const Light& light, float aim_distance, const Bounds& bounds);

/// Where the cone of half angle `angle_deg`, within [0, 89], meets the disc, at `turn_rad` around
/// it.
vec3 cone_point(const SpotCone& cone, float angle_deg, float turn_rad);

/// The half angle of the cone through `p_world`; degrees.
float cone_angle_at(const SpotCone& cone, vec3 p_world);

}  // namespace relume

#pragma once

#include "core/math/vec.h"
#include "core/trace/tracer.h"

namespace relume {

// The rule for shadow rays, relative to the geometry and safe at hair scale.
//
// A sample carries one number, its bias b, in world units:
// - surfaces: b = 2^-17 m, m = the largest absolute world coordinate of the triangle's vertices. A
// hit
//   interpolated from the vertices is exact to about 2^-23 m and a ray-triangle test to a few times
//   that, so b is above the sum of both and four orders below anything a picture shows.
// - strands: b = 2 r, the strand's own diameter at the hit.
//
// A shadow ray from a surface starts at p + b n on the light's side of the shading normal n; from a
// strand at p itself, and it ignores the first b of its length. p lies on the strand's axis:
// strands are ribbons that face each ray, so from there a strand never shadows its own straight
// run, whatever the light's angle (a point off the axis would, up to r / sin^2 of the angle between
// light and strand). Only below atan(1/2) to the strand is a sample within r / sin of the next
// joint shadowed by that segment's end. Both end b before the light.

inline float surface_bias(vec3 v0, vec3 v1, vec3 v2) {
  const float largest =
      std::max(max_abs_component(v0), std::max(max_abs_component(v1), max_abs_component(v2)));
  return std::max(0x1p-17f * largest, 1e-30f);
}

inline float strand_bias(float radius) {
  return 2.0f * radius;
}

/// The shadow ray from `position` to a light at `distance` along the unit vector `wi`; distance may
/// be infinite. `normal` is null or zero on strands.
inline Ray make_shadow_ray(vec3 position, const vec3* normal, float bias, vec3 wi, float distance) {
  Ray ray;
  ray.direction = wi;
  ray.t_far = distance - bias;
  if (normal != nullptr) {
    ray.origin = position + *normal * (glm::dot(*normal, wi) < 0 ? -bias : bias);
  } else {
    ray.origin = position;
    ray.t_near = bias;
  }
  return ray;
}

}  // namespace relume

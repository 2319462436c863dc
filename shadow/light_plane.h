#pragma once

#include <span>
#include <vector>

#include "core/scene/light.h"

namespace relume {

/// A picture plane as a light sees it: square texels over a rectangle of one of six directions. A
/// point light sees 90 degrees a direction; a directional one has a single, parallel view.
struct LightPlane {
  vec3 origin{0};  ///< world: the light; directional: the middle of the receivers
  vec3 x{1, 0, 0};
  vec3 y{0, 1, 0};
  vec3 z{0, 0, 1};  ///< unit, away from the light
  bool perspective = true;
  float scale = 1;     ///< texels per unit of x / z, or of x where parallel
  float offset_u = 0;  ///< texels
  float offset_v = 0;
  float far = 0;   ///< parallel: nearness 0 lies here, world units along z from the origin
  float near = 0;  ///< perspective: nothing closer is seen, world units
  int width = 0;   ///< texels
  int height = 0;

  /// A point on the plane: texels, and how near to the light: 1 / depth, or far - depth where
  /// parallel; both are linear over a triangle's picture.
  struct Projection {
    float u;
    float v;
    float nearness;
  };

  /// In the light's frame: x, y, depth.
  vec3 to_light(vec3 p_world) const {
    const vec3 d = p_world - origin;
    return {glm::dot(d, x), glm::dot(d, y), glm::dot(d, z)};
  }
  /// `p` in the light's frame; perspective: its depth > 0.
  Projection project(vec3 p) const {
    if (!perspective) return {scale * p.x + offset_u, scale * p.y + offset_v, far - p.z};
    const float nearness = 1 / p.z;
    return {scale * p.x * nearness + offset_u, scale * p.y * nearness + offset_v, nearness};
  }
  /// Nearness of what lies `bias` (world units) closer to the light than depth `depth`.
  float nearness_before(float depth, float bias) const {
    if (!perspective) return far - depth + bias;
    return depth > bias ? 1 / (depth - bias) : std::numeric_limits<float>::infinity();
  }
  /// World side of a texel at `depth`.
  float texel_size(float depth) const { return perspective ? depth / scale : 1 / scale; }
};

/// The views that together see every point of `boxes` (world space), fitted to them, of at most
/// `max_texels` texels altogether and one texel density. Views that would see no box are left out.
/// `casters` bounds what can stand between. A light farther than 10,000 radii of the boxes is taken
/// as parallel.
std::vector<LightPlane> fit_light_planes(const Light& light, std::span<const Bounds> boxes,
                                         const Bounds& casters, uint64_t max_texels);

/// Which of the views sees `p_world`: the one within whose 45 degrees it lies; -1 for none.
int find_plane(std::span<const LightPlane> views, vec3 p_world);

}  // namespace relume

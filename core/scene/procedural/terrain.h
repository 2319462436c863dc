#pragma once

#include "core/scene/scene.h"

namespace relume {

/// The rolling ground of a plant field: a height over each point (x, z) of the plane, a path that
/// winds along z, and smooth noise to cluster plants by. A pure function of its parameters.
class Terrain {
 public:
  /// Field of `size` x `size` metres about the origin; heights in it stay within +- `hill_height`,
  /// beyond it the ground falls away.
  Terrain(float size, float hill_height, uint64_t seed);

  float size() const { return size_; }
  float height(vec2 place) const;
  vec3 normal(vec2 place) const;

  /// Distance from the path's middle in units of the path's half width, >= 0.
  float distance_from_path(vec2 place) const;

  /// Smooth noise in [0, 1] with features of size 1; each `channel` is another pattern.
  float noise(vec2 place, uint32_t channel) const;

  /// The ground as a grid with smooth normals, three times as wide as the field.
  Mesh make_mesh(uint32_t material) const;

 private:
  float size_;
  float hill_height_;
  uint64_t seed_;
};

}  // namespace relume

#pragma once

#include <cstdint>
#include <vector>

#include "core/math/transform.h"

namespace relume {

/// Places things at random over a rectangle of the plane y = height.
struct ScatterParams {
  uint32_t count = 1;
  uint32_t kinds = 1;   ///< each placement draws one of so many kinds, evenly; > 0
  vec2 low{-1};         ///< x, z of one corner
  vec2 high{1};         ///< of the other, >= low
  float height = 0;     ///< y
  float scale_low = 1;  ///< uniform scale, drawn evenly from [scale_low, scale_high], > 0
  float scale_high = 1;
  bool rotate = true;      ///< by a random angle about y
  float min_distance = 0;  ///< between the origins of any two placements
  uint64_t seed = 1;
};

struct Placement {
  uint32_t kind = 0;
  mat4x3 world_from_local = identity_transform();
};

/// At most `count` placements: fewer when no free place was found for one within 256 tries. A
/// function of the parameters alone; the first n do not depend on `count`.
std::vector<Placement> scatter(const ScatterParams& params);

}  // namespace relume

#pragma once

#include "core/math/vec.h"

namespace relume {

/// Two unit vectors that complete the unit vector `n` to a right-handed orthonormal frame
/// (Duff et al., "Building an orthonormal basis, revisited", JCGT 6(1), 2017).
struct Frame {
  vec3 tangent;
  vec3 bitangent;
};

inline Frame make_frame(vec3 n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  return {vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
          vec3(b, sign + n.y * n.y * a, -n.y)};
}

}  // namespace relume

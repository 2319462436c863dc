#pragma once

#include "core/math/vec.h"

namespace relume {

inline vec3 transform_point(const mat4x3& m, vec3 p) {
  return m * vec4(p, 1.0f);
}
inline vec3 transform_vector(const mat4x3& m, vec3 v) {
  return m * vec4(v, 0.0f);
}

/// `n` carried by the inverse transpose, not normalised. For a singular transform the result may be
/// zero: pass it through normalize_or.
inline vec3 transform_normal(const mat4x3& m, vec3 n) {
  // The cofactor matrix equals det * inverse transpose and needs no division.
  const vec3 x = m[0];
  const vec3 y = m[1];
  const vec3 z = m[2];
  const vec3 carried = glm::cross(y, z) * n.x + glm::cross(z, x) * n.y + glm::cross(x, y) * n.z;
  return glm::dot(x, glm::cross(y, z)) < 0 ? -carried : carried;
}

/// By how much `m` scales lengths on average: the cube root of |det|.
inline float uniform_scale(const mat4x3& m) {
  return std::cbrt(std::abs(glm::dot(m[0], glm::cross(m[1], m[2]))));
}

/// The transform that applies `b` first and then `a`.
inline mat4x3 compose(const mat4x3& a, const mat4x3& b) {
  return {transform_vector(a, b[0]), transform_vector(a, b[1]), transform_vector(a, b[2]),
          transform_point(a, b[3])};
}

inline mat4x3 identity_transform() {
  return mat4x3(1.0f);
}

}  // namespace relume

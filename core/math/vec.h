#pragma once

// The only include of GLM: aliases in the project's spelling.

#define GLM_FORCE_SIZE_T_LENGTH
#define GLM_ENABLE_EXPERIMENTAL
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_inverse.hpp>
#include <limits>

namespace relume {

using vec2 = glm::vec2;
using vec3 = glm::vec3;
using vec4 = glm::vec4;
using dvec2 = glm::dvec2;
using dvec3 = glm::dvec3;
using uvec3 = glm::uvec3;
using ivec2 = glm::ivec2;
using mat3 = glm::mat3;
/// Affine transform: three basis columns and a translation. Named destination_from_source.
using mat4x3 = glm::mat4x3;

inline constexpr float pi = 3.14159265358979323846f;
inline constexpr float inv_pi = 1.0f / pi;

inline float radians_from_degrees(float degrees) {
  return degrees * (pi / 180.0f);
}

inline bool is_finite(float x) {
  return std::isfinite(x);
}
inline bool is_finite(vec2 v) {
  return is_finite(v.x) && is_finite(v.y);
}
inline bool is_finite(vec3 v) {
  return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}

inline float max_component(vec3 v) {
  return std::max(v.x, std::max(v.y, v.z));
}
inline float max_abs_component(vec3 v) {
  return max_component(glm::abs(v));
}

/// `v` scaled to unit length, computed in double so that no finite vector under- or overflows;
/// `fallback` when v is zero or not finite.
inline vec3 normalize_or(vec3 v, vec3 fallback) {
  const dvec3 wide(v);
  const double length = glm::length(wide);
  return length > 0 && std::isfinite(length) ? vec3(wide / length) : fallback;
}

/// Axis-aligned box; empty until the first extend().
struct Bounds {
  vec3 low{std::numeric_limits<float>::infinity()};
  vec3 high{-std::numeric_limits<float>::infinity()};

  void extend(vec3 p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  void extend(const Bounds& other) {
    low = glm::min(low, other.low);
    high = glm::max(high, other.high);
  }
  bool empty() const { return !(low.x <= high.x); }
  vec3 center() const { return empty() ? vec3(0) : 0.5f * low + 0.5f * high; }
  /// Half the diagonal; 0 when empty.
  float radius() const { return empty() ? 0.0f : 0.5f * glm::length(high - low); }
};

}  // namespace relume

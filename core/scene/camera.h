#pragma once

#include "core/math/vec.h"

namespace relume {

/// Pinhole camera. The view never changes after a scene is prepared.
struct Camera {
  vec3 eye{0, 0, 5};     ///< world
  vec3 target{0, 0, 0};  ///< world, != eye
  vec3 up{0, 1, 0};      ///< world, not parallel to the view direction
  float fov_y_deg = 35;  ///< full vertical angle, (0, 179)
};

/// The target of a camera at `eye` (world) that looks along unit `forward`: so far ahead that
/// floats tell the direction.
inline vec3 target_ahead(vec3 eye, vec3 forward) {
  return eye + forward * std::max(1.0f, 1e-3f * max_abs_component(eye));
}

/// Generates rays for an image of width x height pixels. Pixel (0,0) is the top left one; `film` is
/// in pixels, so the centre of pixel (x, y) is (x + .5, y + .5).
class CameraRays {
 public:
  CameraRays(const Camera& camera, int width, int height)
      : eye_(camera.eye), half_size_(0.5f * vec2(width, height)) {
    const vec3 forward = normalize_or(camera.target - camera.eye, vec3(0, 0, -1));
    const vec3 right = normalize_or(glm::cross(forward, camera.up), vec3(1, 0, 0));
    const vec3 up = glm::cross(right, forward);
    const float per_pixel = std::tan(0.5f * radians_from_degrees(camera.fov_y_deg)) / half_size_.y;
    forward_ = forward;
    right_per_px_ = right * per_pixel;
    up_per_px_ = up * per_pixel;
    radians_per_px_ = per_pixel;
  }

  vec3 eye() const { return eye_; }
  vec3 forward() const { return forward_; }
  vec3 right() const { return normalize_or(right_per_px_, vec3(1, 0, 0)); }
  vec3 up() const { return normalize_or(up_per_px_, vec3(0, 1, 0)); }
  /// Side of a pixel's footprint per unit of depth along forward().
  float footprint_per_depth() const { return radians_per_px_; }

  /// Unit direction from the eye through the film position.
  vec3 direction(vec2 film_px) const {
    const vec2 offset = film_px - half_size_;
    return glm::normalize(forward_ + right_per_px_ * offset.x - up_per_px_ * offset.y);
  }

  /// Where a world point falls on the film, in pixels; `depth` along forward() is <= 0 behind the
  /// eye.
  struct Projection {
    vec2 film_px;
    float depth;
  };
  Projection project(vec3 p_world) const {
    const vec3 v = p_world - eye_;
    const float depth = glm::dot(v, forward_);
    const float scale = 1.0f / (std::max(depth, 1e-20f) * radians_per_px_);
    return {half_size_ + vec2(glm::dot(v, right()), -glm::dot(v, up())) * scale, depth};
  }

 private:
  vec3 eye_;
  vec3 forward_;
  vec3 right_per_px_;
  vec3 up_per_px_;
  float radians_per_px_;
  vec2 half_size_;
};

}  // namespace relume

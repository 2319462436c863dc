#pragma once

#include <string>
#include <vector>

#include "core/trace/tracer.h"

namespace relume {

/// What a view looks at, from 64 x 64 rays through it.
struct ViewFocus {
  vec3 center{0};      ///< world: the median of what the rays met, by axis
  float radius = 1;    ///< world: 1.5 times the median distance from it
  vec3 point{0};       ///< world: the hit nearest to the centre as the camera sees it
  float pixel = 0;     ///< world: side of a pixel at the centre
  bool empty = false;  ///< no ray met anything
};

/// `width` x `height` in pixels, of the whole picture.
ViewFocus find_focus(const Scene& scene, const Tracer& tracer, int width, int height);

/// A light of the study and the places it moves to.
struct StudyLight {
  std::string name;
  /// First where it stands, then further steps along a path, each of which moves the shadow of what
  /// stands a focus radius off its caster by about one pixel.
  std::vector<Light> path;
};

/// The lights that shadows are measured under, placed relative to the focus and the camera:
/// `beside` (front right, high), `low` (behind and left, raking), `overhead`, `inside` (a point
/// light in front of what is seen in the middle, a twelfth of the radius off its surface) and
/// `directional`. `steps` >= 0 further places each. Gains make each irradiance 1 at the centre, the
/// inside light's 1 at a quarter of the radius.
std::vector<StudyLight> make_study_lights(const Scene& scene, const ViewFocus& focus, int steps);

}  // namespace relume

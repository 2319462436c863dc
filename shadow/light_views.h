#pragma once

#include <array>
#include <vector>

#include "core/math/vec.h"
#include "core/scene/light.h"
#include "shadow/coverage_kernel.h"

namespace relume {

inline constexpr size_t max_light_views = 6;

/// How a light looks at receivers within the unit sphere: one view from outside, a cube of six from
/// within. Depths and places are relative to the receivers, not to the light, so that a light a
/// million radii away loses nothing.
struct LightViews {
  std::vector<CoverageView> views;
  float extent = 1;  ///< |u| and |v| of what lies in the unit sphere are at most that
  bool is_parallel = false;
  dvec3 position{0};        ///< of the light, where it is not parallel
  dvec3 to_light{0, 1, 0};  ///< unit, where it is parallel; against a spot's direction
  double cos_outer = -1;    ///< spots: below it there is no light

  /// The view that a receiver belongs to: the face of the cube that it is seen through.
  size_t view_of(vec3 p) const;
};

/// `center` and `scale` of the receivers' space.
LightViews make_light_views(const Light& light, dvec3 center, double scale);

/// x, y, d and w of a point.
struct ViewPoint {
  float x, y, d, w;
};
inline ViewPoint view_point(const CoverageView& view, vec3 p) {
  const auto row = [&](int i) {
    const float* r = view.row[i];
    return r[0] * p.x + r[1] * p.y + r[2] * p.z + r[3];
  };
  const float d = row(2);
  return {row(0), row(1), d, 1 + view.k * d};
}

}  // namespace relume

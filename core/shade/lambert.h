#pragma once

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// Ideal diffuse reflection: f = diffuse / pi.
struct Lambert {
  static constexpr std::array<SampleField, 4> fields{{
      position_field_info,
      bias_field_info,
      {"normal", 3, FieldKind::direction, FieldSource::normal, "1", Merge::average},
      {"diffuse", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.5f},
  }};
  static constexpr ShaderInfo info{"lambert", fields};

  /// Radiance towards `wo` per unit irradiance on a plane that faces the light, f * cos, in double.
  /// `v` is one sample vector in the order of `fields`; `wi` to the light, `wo` to the eye, unit.
  static dvec3 reference(const double* v, dvec3 wi, dvec3 /*wo*/) {
    const dvec3 n(v[4], v[5], v[6]);
    const dvec3 diffuse(v[7], v[8], v[9]);
    return diffuse / 3.14159265358979323846 * std::max(0.0, glm::dot(n, wi));
  }

  /// The same for one pack of records; `f(i)` loads float i of the sample vectors.
  template <class F, class Load, class Vec>
  static auto kernel(const Load& f, const Vec& wi, const Vec& /*wo*/) {
    const F cosine = max(F(0), dot(Vec{f(4), f(5), f(6)}, wi)) * F(inv_pi);
    return Vec{f(7) * cosine, f(8) * cosine, f(9) * cosine};
  }
};

}  // namespace relume

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

  /// The same as lobes: response = sum over lobes of color * lobe. `colors` holds the first float
  /// of each lobe's colour; `f(i)` loads float i of the sample vectors. F is a pack of floats or of
  /// dual numbers, so derivatives need no code here.
  static constexpr int colors[] = {7};
  template <class F, class Load, class Vec>
  static Lobes<F, 1> lobes(const Load& f, const Vec& wi, const Vec& /*wo*/) {
    return {{max(dot(Vec{f(4), f(5), f(6)}, wi), F(0)) * F(inv_pi)}};
  }
};

}  // namespace relume

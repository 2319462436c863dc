#pragma once

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// A thin two-sided leaf: diffuse reflection of light from the eye's side, diffuse transmission of
/// light from behind: f * |cos| with f = diffuse / pi or transmit / pi.
struct Leaf {
  static constexpr std::array<SampleField, 5> fields{{
      position_field_info,
      bias_field_info,
      {"normal", 3, FieldKind::direction, FieldSource::normal, "1", Merge::average},
      {"diffuse", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.3f},
      {"transmit", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.2f},
  }};
  static constexpr ShaderInfo info{"leaf", fields, true};

  /// As Lambert::reference. The normal faces the eye.
  static dvec3 reference(const double* v, dvec3 wi, dvec3 /*wo*/) {
    const double pi_double = 3.14159265358979323846;
    const double n_wi = glm::dot(dvec3(v[4], v[5], v[6]), wi);
    const dvec3 color = n_wi > 0 ? dvec3(v[7], v[8], v[9]) : dvec3(v[10], v[11], v[12]);
    return color / pi_double * std::abs(n_wi);
  }

  /// As Lambert::lobes.
  static constexpr int colors[] = {7, 10};
  template <class F, class Load, class Vec>
  static Lobes<F, 2> lobes(const Load& f, const Vec& wi, const Vec& /*wo*/) {
    const F n_wi = dot(Vec{f(4), f(5), f(6)}, wi) * F(inv_pi);
    return {{max(n_wi, F(0)), max(F(0) - n_wi, F(0))}};
  }
};

}  // namespace relume

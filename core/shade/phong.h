#pragma once

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// Diffuse plus a normalised Phong lobe about the mirror direction r of wi:
/// f * cos = (diffuse / pi + specular (e + 2) / (2 pi) max(0, r.wo)^e) max(0, n.wi)
/// (Lafortune and Willems, "Using the modified Phong reflectance model", 1994).
struct Phong {
  static constexpr std::array<SampleField, 6> fields{{
      position_field_info,
      bias_field_info,
      {"normal", 3, FieldKind::direction, FieldSource::normal, "1", Merge::average},
      {"diffuse", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.5f},
      {"specular", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.05f},
      {"exponent", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1e5f, 40},
  }};
  static constexpr ShaderInfo info{"phong", fields};

  /// As Lambert::reference.
  static dvec3 reference(const double* v, dvec3 wi, dvec3 wo) {
    const double two_pi = 2 * 3.14159265358979323846;
    const dvec3 n(v[4], v[5], v[6]);
    const dvec3 diffuse(v[7], v[8], v[9]);
    const dvec3 specular(v[10], v[11], v[12]);
    const double exponent = v[13];
    const double n_wi = glm::dot(n, wi);
    if (!(n_wi > 0)) return dvec3(0);
    const double r_wo = std::max(0.0, glm::dot(2.0 * n_wi * n - wi, wo));
    const double lobe = (exponent + 2) / two_pi * std::pow(r_wo, exponent);
    return (diffuse * (2 / two_pi) + specular * lobe) * n_wi;
  }

  /// As Lambert::lobes.
  static constexpr int colors[] = {7, 10};
  template <class F, class Load, class Vec>
  static Lobes<F, 2> lobes(const Load& f, const Vec& wi, const Vec& wo) {
    const Vec n{f(4), f(5), f(6)};
    const F n_wi = max(dot(n, wi), F(0));
    const F r_wo = max(F(2) * n_wi * dot(n, wo) - dot(wi, wo), F(0));
    const F exponent = f(13);
    return {
        {n_wi * F(inv_pi), n_wi * (exponent + F(2)) * F(0.5f * inv_pi) * pow_unit(r_wo, exponent)}};
  }
};

}  // namespace relume

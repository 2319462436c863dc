#pragma once

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// Strands: Kajiya and Kay, "Rendering fur with three dimensional textures", 1989, sec. 3.2, with
/// both lobes normalised as in Phong. With the angles between the tangent t and wi, wo: f * cos =
/// diffuse / pi sin(t,wi) + specular (e + 2) / (2 pi) max(0, sin sin - cos cos)^e. The sign: the
/// mirror cone has the opposite cosine, so the peak is at t.wo = -t.wi. The sign of t cancels. No
/// self-shadowing term: visibility is the shadow module's.
struct KajiyaKay {
  static constexpr std::array<SampleField, 6> fields{{
      position_field_info,
      bias_field_info,
      {"tangent", 3, FieldKind::axis, FieldSource::tangent, "1", Merge::average},
      {"diffuse", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.3f},
      {"specular", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.05f},
      {"exponent", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1e5f, 40},
  }};
  static constexpr ShaderInfo info{"kajiya-kay", fields};

  /// As Lambert::reference.
  static dvec3 reference(const double* v, dvec3 wi, dvec3 wo) {
    const double two_pi = 2 * 3.14159265358979323846;
    const dvec3 t(v[4], v[5], v[6]);
    const dvec3 diffuse(v[7], v[8], v[9]);
    const dvec3 specular(v[10], v[11], v[12]);
    const double exponent = v[13];
    const double cos_i = glm::dot(t, wi);
    const double cos_o = glm::dot(t, wo);
    const double sin_i = std::sqrt(std::max(0.0, 1 - cos_i * cos_i));
    const double sin_o = std::sqrt(std::max(0.0, 1 - cos_o * cos_o));
    const double peak = std::clamp(sin_i * sin_o - cos_i * cos_o, 0.0, 1.0);
    const double lobe = (exponent + 2) / two_pi * std::pow(peak, exponent);
    return diffuse * (2 / two_pi * sin_i) + specular * lobe;
  }

  /// As Lambert::lobes.
  static constexpr int colors[] = {7, 10};
  template <class F, class Load, class Vec>
  static Lobes<F, 2> lobes(const Load& f, const Vec& wi, const Vec& wo) {
    const Vec t{f(4), f(5), f(6)};
    const F cos_i = dot(t, wi);
    const F cos_o = dot(t, wo);
    const F sin_i = sqrt(max(F(1) - cos_i * cos_i, F(0)));
    const F sin_o = sqrt(max(F(1) - cos_o * cos_o, F(0)));
    const F peak = max(sin_i * sin_o - cos_i * cos_o, F(0));
    const F exponent = f(13);
    return {{sin_i * F(inv_pi), (exponent + F(2)) * F(0.5f * inv_pi) * pow_unit(peak, exponent)}};
  }
};

}  // namespace relume

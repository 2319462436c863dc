#pragma once

#include "core/math/vec.h"
#include "core/scene/shader_info.h"

namespace relume {

/// The metallic-roughness model of glTF 2.0, appendix B: diffuse reflection under a layer of GGX
/// microfacets with separable Smith masking and Schlick's Fresnel term. With alpha = roughness^2,
/// the half vector h and w = (1 - |wo.h|)^5,
/// f * cos = (diffuse (1 - w) / pi + specular (r + (1 - r) w) D G / (4 (n.wi) (n.wo))) max(0, n.wi)
/// Ours differs in one thing: Schlick's F0 is kept as its brightest component r (`reflectance`) and
/// its hue (`specular`), so that the response is linear in two colours and a mean of samples never
/// reflects more than arrives. Towards grazing angles F0 / r is reached where glTF has white: the
/// same for what is grey there, which all dielectrics are. alpha is at least 1e-3.
struct Ggx {
  static constexpr std::array<SampleField, 7> fields{{
      position_field_info,
      bias_field_info,
      {"normal", 3, FieldKind::direction, FieldSource::normal, "1", Merge::average},
      {"diffuse", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.48f},
      {"specular", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 1},
      {"reflectance", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1,
       0.04f},
      {"roughness", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1, 0.5f},
  }};
  /// `reflectance` is F0 of what is not metal.
  static constexpr std::array<SampleField, 4> parameters{{
      {"base_color", 3, FieldKind::linear, FieldSource::material, "1", Merge::average, 0, 1, 0.5f},
      {"metallic", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1, 0},
      {"reflectance", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1,
       0.04f},
      {"roughness", 1, FieldKind::scalar, FieldSource::material, "1", Merge::average, 0, 1, 0.5f},
  }};
  /// Values of `parameters` to those of the four material fields. Defined apart, in ggx.cpp: the
  /// table that holds its address is part of kernel sources.
  static void fields_of_parameters(const vec3* parameters, vec3* fields);
  static constexpr ShaderInfo info{"ggx", fields, false, parameters, fields_of_parameters};

  static constexpr float min_alpha = 1e-3f;

  /// As Lambert::reference.
  static dvec3 reference(const double* v, dvec3 wi, dvec3 wo) {
    const double pi_double = 3.14159265358979323846;
    const dvec3 n(v[4], v[5], v[6]);
    const dvec3 diffuse(v[7], v[8], v[9]);
    const dvec3 specular(v[10], v[11], v[12]);
    const double n_wi = glm::dot(n, wi);
    if (!(n_wi > 0)) return dvec3(0);
    const double n_wo = std::max(0.0, glm::dot(n, wo));
    const double h_length = glm::length(wi + wo);
    const dvec3 h = h_length > 1e-6 ? (wi + wo) / h_length : n;
    const double alpha = std::max(v[14] * v[14], double{min_alpha});
    const double a2 = alpha * alpha;
    const double n_h = glm::dot(n, h);
    const double spread = n_h * n_h * (a2 - 1) + 1;
    const double d = a2 / (pi_double * spread * spread);
    const auto masking = [a2](double cosine) {
      return 1 / (cosine + std::sqrt(a2 + (1 - a2) * cosine * cosine));
    };
    const double w = std::pow(std::clamp(1 - glm::dot(wo, h), 0.0, 1.0), 5);
    const double fresnel = v[13] + (1 - v[13]) * w;
    return (diffuse * ((1 - w) / pi_double) +
            specular * (fresnel * d * masking(n_wi) * masking(n_wo))) *
           n_wi;
  }

  /// As Lambert::lobes. The spread of microfacets is taken from the sine of the angle between n and
  /// h, whose cosine has too few digits for smooth surfaces.
  static constexpr int colors[] = {7, 10};
  template <class F, class Load, class Vec>
  static Lobes<F, 2> lobes(const Load& f, const Vec& wi, const Vec& wo) {
    const Vec n{f(4), f(5), f(6)};
    const Vec h{wi.x + wo.x, wi.y + wo.y, wi.z + wo.z};
    const Vec cross{n.y * h.z - n.z * h.y, n.z * h.x - n.x * h.z, n.x * h.y - n.y * h.x};
    const F n_wi = max(dot(n, wi), F(0));
    const F n_wo = max(dot(n, wo), F(0));
    const F inverse_length = rsqrt(max(dot(h, h), F(1e-12f)));
    const F alpha = max(f(14) * f(14), F(min_alpha));
    const F a2 = alpha * alpha;
    const F rest = F(1) - a2;
    const F spread = fma(dot(cross, cross) * inverse_length * inverse_length, rest, a2);
    const F masking =
        (n_wi + sqrt(fma(rest, n_wi * n_wi, a2))) * (n_wo + sqrt(fma(rest, n_wo * n_wo, a2)));
    const F facing = max(dot(wo, h), F(0)) * inverse_length;
    const F away = max(F(1) - facing, F(0));
    const F w = away * away * away * away * away;
    const F fresnel = fma(F(1) - f(13), w, f(13));
    const F lit = n_wi * F(inv_pi);
    return {{lit * (F(1) - w), lit * fresnel * a2 / (spread * spread * masking)}};
  }
};

}  // namespace relume

#include "viewer/session/light_color.h"

#include "core/math/color.h"

namespace relume {
namespace {

constexpr double largest_distance = 0.06;  // in u, v
constexpr int search_steps = 64;

/// CIE 1960 chromaticity of the black body.
dvec2 planckian_uv(double t) {
  return {(0.860117757 + 1.54118254e-4 * t + 1.28641212e-7 * t * t) /
              (1 + 8.42420235e-4 * t + 7.08145163e-7 * t * t),
          (0.317398726 + 4.22806245e-5 * t + 4.20481691e-8 * t * t) /
              (1 - 2.89741816e-5 * t + 1.61456053e-7 * t * t)};
}

dvec3 linear_from_xyz(dvec3 c) {
  return {3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z,
          -0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z,
          0.0556434 * c.x - 0.2040259 * c.y + 1.0572252 * c.z};
}

dvec3 xyz_from_linear(dvec3 c) {
  return {0.4124564 * c.x + 0.3575761 * c.y + 0.1804375 * c.z,
          0.2126729 * c.x + 0.7151522 * c.y + 0.0721750 * c.z,
          0.0193339 * c.x + 0.1191920 * c.y + 0.9503041 * c.z};
}

/// Black bodies that Rec. 709 cannot show are met as they are shown.
dvec2 shown_uv(double kelvin) {
  const dvec3 xyz =
      xyz_from_linear(dvec3(color_of_temperature(static_cast<float>(kelvin), vec3(1))));
  return dvec2(4 * xyz.x, 6 * xyz.y) / (xyz.x + 15 * xyz.y + 3 * xyz.z);
}

}  // namespace

vec3 color_of_temperature(float kelvin, vec3 like) {
  const dvec2 uv = planckian_uv(std::clamp(kelvin, min_temperature_k, max_temperature_k));
  const double scale = 2 * uv.x - 8 * uv.y + 4;
  const double x = 3 * uv.x / scale;
  const double y = 2 * uv.y / scale;
  const vec3 color(glm::max(linear_from_xyz({x / y, 1, (1 - x - y) / y}), dvec3(0)));
  return color * (luminance(like) / luminance(color));
}

std::optional<float> temperature_of_color(vec3 color) {
  const dvec3 xyz = xyz_from_linear(dvec3(color));
  const double sum = xyz.x + 15 * xyz.y + 3 * xyz.z;
  if (!(xyz.y > 0) || !std::isfinite(sum)) return std::nullopt;
  const dvec2 uv = dvec2(4 * xyz.x, 6 * xyz.y) / sum;
  const auto distance = [&](double mired) { return glm::distance(shown_uv(1e6 / mired), uv); };
  // The locus is almost evenly spaced in mired; around the best of a grid there is one minimum.
  const double low_mired = 1e6 / max_temperature_k;
  const double step = (1e6 / min_temperature_k - low_mired) / search_steps;
  double best = low_mired;
  for (int i = 1; i <= search_steps; ++i) {
    const double mired = low_mired + step * i;
    if (distance(mired) < distance(best)) best = mired;
  }
  double low = std::max(low_mired, best - step);
  double high = std::min(1e6 / min_temperature_k, best + step);
  for (int i = 0; i < search_steps; ++i) {
    const double third = (high - low) / 3;
    if (distance(low + third) < distance(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  if (distance(0.5 * (low + high)) > largest_distance) return std::nullopt;
  return static_cast<float>(1e6 / (0.5 * (low + high)));
}

}  // namespace relume

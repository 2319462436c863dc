#include "core/samples/footprint.h"

#include "core/samples/record_encode.h"

namespace relume {
namespace {

constexpr double largest_fraction = 32767;
/// Codes outside would let squares leave a float's range; no coordinate is that large, no cluster
/// that small.
constexpr int smallest_exponent_code = 127 - 45;
constexpr int largest_exponent_code = 127 + 40;

/// Lower triangle of a covariance's Cholesky factor, row by row. Directions without extent get 0.
std::array<double, 6> factor_covariance(const std::array<float, 6>& covariance) {
  const double xx = covariance[0];
  const double xy = covariance[1];
  const double xz = covariance[2];
  const double yy = covariance[3];
  const double yz = covariance[4];
  const double zz = covariance[5];
  // Below what float entries carry, a pivot is rounding.
  const double least = 1e-7 * (xx + yy + zz);
  std::array<double, 6> l{};
  if (xx > least) {
    l[0] = std::sqrt(xx);
    l[1] = xy / l[0];
    l[3] = xz / l[0];
  }
  const double pivot_y = yy - l[1] * l[1];
  if (pivot_y > least) {
    l[2] = std::sqrt(pivot_y);
    l[4] = (yz - l[1] * l[3]) / l[2];
  }
  const double pivot_z = zz - l[3] * l[3] - l[4] * l[4];
  if (pivot_z > least) l[5] = std::sqrt(pivot_z);
  return l;
}

uint32_t encode_fraction(double x, double scale) {
  const double steps = scale > 0 ? std::floor(x / scale * largest_fraction + 0.5) : 0;
  const auto code = static_cast<int16_t>(std::clamp(steps, -largest_fraction, largest_fraction));
  return static_cast<uint16_t>(code);
}

float decode_fraction(uint32_t bits, float scale) {
  return static_cast<float>(static_cast<int16_t>(bits & 0xffffu)) *
         (scale / static_cast<float>(largest_fraction));
}

float scale_of_code(uint32_t code) {
  if (code == 0) return 0;
  const int exponent =
      std::clamp(static_cast<int>(code), smallest_exponent_code, largest_exponent_code) - 127;
  return std::ldexp(1.0f, exponent);
}

/// The exponent code of the least power of two above `x`.
uint32_t code_of_scale(double x) {
  if (!(x > 0)) return 0;
  return static_cast<uint32_t>(
      std::clamp(std::ilogb(x) + 1 + 127, smallest_exponent_code, largest_exponent_code));
}

}  // namespace

FootprintWords encode_footprint(const Footprint& footprint) {
  const std::array<double, 6> l = factor_covariance(footprint.covariance);
  double largest = max_abs_component(footprint.offset);
  for (const double x : l) largest = std::max(largest, std::abs(x));
  const uint32_t code = code_of_scale(largest);
  const auto scale = static_cast<double>(scale_of_code(code));
  const auto pair = [scale](double a, double b) {
    return encode_fraction(a, scale) | encode_fraction(b, scale) << 16;
  };
  const auto samples = static_cast<uint32_t>(std::clamp(footprint.samples, 1, max_members));
  return {pair(footprint.offset.x, footprint.offset.y),
          encode_fraction(footprint.offset.z, scale) | code << 16 | samples << 24, pair(l[0], l[1]),
          pair(l[2], l[3]), pair(l[4], l[5])};
}

Footprint decode_footprint(const FootprintWords& words) {
  const float scale = scale_of_code(words[1] >> 16 & 0xffu);
  const auto low = [&](int i) { return decode_fraction(words[i], scale); };
  const auto high = [&](int i) { return decode_fraction(words[i] >> 16, scale); };
  Footprint footprint;
  footprint.offset = {low(0), high(0), low(1)};
  const vec3 x(low(2), high(2), high(3));  // the factor's columns
  const vec3 y(0, low(3), low(4));
  const vec3 z(0, 0, high(4));
  const auto entry = [&](size_t i, size_t j) { return x[i] * x[j] + y[i] * y[j] + z[i] * z[j]; };
  footprint.covariance = {entry(0, 0), entry(0, 1), entry(0, 2),
                          entry(1, 1), entry(1, 2), entry(2, 2)};
  footprint.samples = std::max(1, static_cast<int>(words[1] >> 24));
  return footprint;
}

PackedMember encode_member(const Member& member, float scale) {
  PackedMember packed;
  for (int i = 0; i < 3; ++i) {
    packed.offset[i] = static_cast<int16_t>(encode_fraction(member.offset[i], scale));
  }
  const vec2 p = fold_octahedron(member.normal);
  for (int i = 0; i < 2; ++i) {
    packed.normal[i] =
        static_cast<uint8_t>(std::clamp(std::floor((p[i] + 1) * 127.5f + 0.5f), 0.0f, 255.0f));
  }
  return packed;
}

Member decode_member(const PackedMember& packed, float scale, bool on_surface) {
  Member member;
  for (int i = 0; i < 3; ++i) {
    member.offset[i] = decode_fraction(static_cast<uint16_t>(packed.offset[i]), scale);
  }
  if (!on_surface) return member;
  const float u = static_cast<float>(packed.normal[0]) / 127.5f - 1;
  const float v = static_cast<float>(packed.normal[1]) / 127.5f - 1;
  vec3 d(u, v, 1 - std::abs(u) - std::abs(v));
  const float fold = std::max(-d.z, 0.0f);
  d.x -= std::copysign(fold, u);
  d.y -= std::copysign(fold, v);
  member.normal = normalize_or(d, {0, 0, 1});
  return member;
}

float member_scale(const Footprint& stored) {
  const float trace = stored.covariance[0] + stored.covariance[3] + stored.covariance[5];
  return max_abs_component(stored.offset) +
         std::sqrt(static_cast<float>(stored.samples) * std::max(trace, 0.0f));
}

}  // namespace relume
